"""Numbers, units and names as the pages write them."""

import math
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

import pandas as pd
import yaml

NAMES = yaml.safe_load(
    (Path(__file__).with_name("pages") / "names.yaml").read_text(encoding="utf-8")
)

DECIBEL_DECIMALS = 2  # of reductions without an error [dB]

SUPERSCRIPT = str.maketrans("-−0123456789", "⁻⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, digits: int = 3) -> str:
    """Return a number with ``digits`` significant digits, as a power of ten outside 1e-4 to 1e5.

    Examples
    --------
    >>> number(0.123456), number(0.9996), number(-1234.5), number(9.4e-9), number(float("nan"))
    ('0.123', '1.00', '−1234', '9.40·10⁻⁹', '–')
    """
    if not math.isfinite(value):
        return "–"
    if value != 0 and not 1e-4 <= abs(value) < 1e5:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        return _minus(mantissa) + f"·10{str(int(exponent)).translate(SUPERSCRIPT)}"
    order = int(f"{value:.{digits - 1}e}".split("e")[1])  # of the rounded value
    return _minus(f"{value:.{max(0, digits - 1 - order)}f}")


def with_error(value: float, error: float) -> str:
    """Return value ± standard error, both to two digits of the error.

    Examples
    --------
    >>> with_error(495.3, 12.3), with_error(-0.4567, 0.0231), with_error(32077, 1399)
    ('495 ± 12', '−0.457 ± 0.023', '32100 ± 1400')
    >>> with_error(0.000112, 0.0000014), with_error(-0.00001, 0.01)
    ('(1.120 ± 0.014)·10⁻⁴', '0.000 ± 0.010')
    """
    if not (math.isfinite(value) and math.isfinite(error)):
        return "–"
    if error <= 0:
        return number(value)
    largest = max(abs(value), error)
    if largest < 1e-3:
        power = math.floor(math.log10(largest))
        scaled = with_error(value * 10.0**-power, error * 10.0**-power)
        return f"({scaled})·10{str(power).translate(SUPERSCRIPT)}"
    decimals = 1 - math.floor(math.log10(error))
    value, error = round(value, decimals), round(error, decimals)
    return f"{plain(value, max(0, decimals))} ± {error:.{max(0, decimals)}f}"


def value_text(value: float, error: float, decimals: int | None = None) -> str:
    """Return a value with its error, or alone where it has none.

    Without ``decimals`` there are two digits of the error. The values of a table all have the
    decimals of `common_decimals`.

    Examples
    --------
    >>> value_text(20.163, 0.694), value_text(20.163, float("nan"))
    ('20.16 ± 0.69', '20.2')
    >>> value_text(-2.986, 0.299, decimals=1), value_text(66.545, 0.014, decimals=1)
    ('−3.0 ± 0.3', '66.5 ± <0.1')
    """
    if decimals is None:
        return with_error(value, error) if error > 0 else number(value)
    if not math.isfinite(value):
        return "–"
    if not error > 0:
        return plain(value, decimals)
    text = f"{error:.{decimals}f}"
    if float(text) == 0:
        text = f"<{10.0**-decimals:.{decimals}f}"
    return f"{plain(value, decimals)} ± {text}"


def common_decimals(errors: Iterable[float], default: int | None = None) -> int | None:
    """Return the decimals of all values of a table: two digits of the largest error.

    The default where no value has an error.

    Examples
    --------
    >>> common_decimals([0.054, 1.9, float("nan")]), common_decimals([123.0]), common_decimals([])
    (1, 0, None)
    """
    finite = [error for error in errors if math.isfinite(error) and error > 0]
    return max(0, 1 - math.floor(math.log10(max(finite)))) if finite else default


def plain(value: float, decimals: int) -> str:
    """Return a number with ``decimals`` decimals, zero without a sign.

    Examples
    --------
    >>> plain(-0.004, 2), plain(-2.986, 1)
    ('0.00', '−3.0')
    """
    text = f"{value:.{decimals}f}"
    return _minus(text.lstrip("-") if float(text) == 0 else text)


def percent(share: float, decimals: int = 0) -> str:
    """Return a share in percent.

    Examples
    --------
    >>> percent(0.4567), percent(-0.0123, 1)
    ('46 %', '−1.2 %')
    """
    return _minus(f"{100 * share:.{decimals}f} %")


def chance(probability: float) -> str:
    """Return a probability in percent, without the sign.

    Examples
    --------
    >>> chance(0.0123), chance(1e-9)
    ('1.2', 'below 0.01')
    """
    return "below 0.01" if probability < 1e-4 else number(100 * probability, 2)


def signed(value: float, decimals: int) -> str:
    """Return a number with its sign.

    Examples
    --------
    >>> signed(6.04, 1), signed(-0.00127, 4)
    ('+6.0', '−0.0013')
    """
    return _minus(f"{value:+.{decimals}f}")


def unit(name: str) -> str:
    """Return a unit of a table of results as the pages write it.

    Examples
    --------
    >>> unit("kg/m2"), unit("N/m"), unit("microstrain"), unit("1")
    ('kg/m²', 'N/m', 'µm/m', '–')
    """
    name = {"microstrain": "µm/m", "1": "–"}.get(name, name)
    return re.sub(r"(?<=[A-Za-z])\d", lambda power: power[0].translate(SUPERSCRIPT), name)


def nominal(centre: float) -> str:
    """Return the nominal centre of a third octave (ISO 266).

    Examples
    --------
    >>> nominal(31.6), nominal(158.5), nominal(1258.9)
    ('31.5', '160', '1250')
    """
    preferred = (1, 1.25, 1.6, 2, 2.5, 3.15, 4, 5, 6.3, 8)
    exponent, rank = divmod(round(10 * math.log10(centre)), 10)
    return f"{preferred[rank] * 10.0**exponent:g}"


def counted(count: int, noun: str) -> str:
    """Return a number of things in words.

    Examples
    --------
    >>> counted(1, "case"), counted(90, "case")
    ('1 case', '90 cases')
    """
    return f"{count} {noun}" + "s" * (count != 1)


def spaced(count: float) -> str:
    """Return a count with a space before each three digits.

    Examples
    --------
    >>> spaced(25041.0)
    '25 041'
    """
    return f"{int(count):,}".replace(",", " ")


def capitalised(text: str) -> str:
    """Return a text with a capital at its start."""
    return text[:1].upper() + text[1:]


def span(texts: Iterable[str], joint: str = " to ") -> str:
    """Return the least and the greatest of some values in one text, or the only one.

    Examples
    --------
    >>> span(["0.1", "0.3"]), span(["2", "2"])
    ('0.1 to 0.3', '2')
    """
    return joint.join(dict.fromkeys(texts))


def records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """Return the rows of a frame by the names of its columns."""
    return [dict(zip(frame.columns, row, strict=True)) for row in frame.itertuples(index=False)]


def _minus(text: str) -> str:
    return text.replace("-", "−")
