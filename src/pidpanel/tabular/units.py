"""Units as the labels of axes have them: ``g^2/Hz``, ``(mm/s²)²/Hz``, ``[g rms]²/Hz``, ``m s-2``.

A label is a product of units with whole powers, from left to right; ``g`` is the acceleration.
"""

import math
import re
from collections.abc import Iterable
from typing import NamedTuple

from pidpanel.constants import STANDARD_GRAVITY


class UnitError(ValueError):
    """A label that is no unit which is known."""


class Unit(NamedTuple):
    """A unit in SI, with the exponents of length, mass and time; of angles in cycles."""

    factor: float
    length: int = 0
    mass: int = 0
    time: int = 0

    @property
    def dimension(self) -> tuple[int, ...]:
        """Exponents of length, mass and time."""
        return tuple(self[1:])

    def power(self, exponent: int) -> "Unit":
        """Return a power of the unit."""
        return Unit(self.factor**exponent, *(exponent * part for part in self.dimension))

    def multiply(self, unit: "Unit") -> "Unit":
        """Return the product with another unit."""
        exponents = zip(self.dimension, unit.dimension, strict=True)
        return Unit(self.factor * unit.factor, *map(sum, exponents))

    def divide(self, unit: "Unit") -> "Unit":
        """Return the ratio to another unit."""
        return self.multiply(unit.power(-1))


def _named(names: str, factor: float, *exponents: int) -> dict[str, Unit]:
    return dict.fromkeys(names.split(), Unit(factor, *exponents))


DIMENSIONLESS, HERTZ = Unit(1.0), Unit(1.0, 0, 0, -1)
KILOGRAM = Unit(1.0, 0, 1)
GRAVITY, NEWTON = Unit(STANDARD_GRAVITY, 1, 0, -2), Unit(1.0, 1, 1, -2)
POUND = 0.45359237  # [kg]
UNITS = {
    **_named("m meter meters metre metres", 1.0, 1),
    **_named("mm", 1e-3, 1), **_named("cm", 1e-2, 1), **_named("um µm μm", 1e-6, 1),
    **_named("km", 1e3, 1),
    **_named("in inch inches", 0.0254, 1), **_named("ft foot feet", 0.3048, 1),
    **_named("s sec second seconds", 1.0, 0, 0, 1), **_named("ms msec", 1e-3, 0, 0, 1),
    **_named("min", 60.0, 0, 0, 1),
    **_named("Hz hz Hertz hertz cps", 1.0, 0, 0, -1), **_named("kHz khz KHz Khz", 1e3, 0, 0, -1),
    **_named("MHz", 1e6, 0, 0, -1), **_named("rpm cpm", 1 / 60, 0, 0, -1),
    **_named("rad", 1 / math.tau), **_named("deg", 1 / 360), **_named("%", 1e-2),
    **_named("g gs Gs g's G's", *GRAVITY), **_named("mg", 1e-3 * STANDARD_GRAVITY, 1, 0, -2),
    **_named("ug µg μg", 1e-6 * STANDARD_GRAVITY, 1, 0, -2),
    **_named("Gal gal", 1e-2, 1, 0, -2),
    **_named("kg", 1.0, 0, 1), **_named("lbm", POUND, 0, 1),
    **_named("slug", POUND * STANDARD_GRAVITY / 0.3048, 0, 1),
    **_named("N newton newtons", *NEWTON), **_named("kN", 1e3, *NEWTON.dimension),
    **_named("mN", 1e-3, *NEWTON.dimension), **_named("cN", 1e-2, *NEWTON.dimension),
    **_named("dyn", 1e-5, *NEWTON.dimension),
    **_named("kgf kp", STANDARD_GRAVITY, *NEWTON.dimension),
    **_named("Pa", 1.0, -1, 1, -2), **_named("kPa", 1e3, -1, 1, -2),
    **_named("psi", POUND * STANDARD_GRAVITY / 0.0254**2, -1, 1, -2),
    **_named("lbf", POUND * STANDARD_GRAVITY, *NEWTON.dimension),
}  # fmt: skip
# Names in capitals alone are those of old files, unless they may be another unit.
AMBIGUOUS = {"MN", "MG", "UG", "MS", "MHZ", "GAL"}
CAPITALS = {name.upper(): unit for name, unit in UNITS.items() if name.upper() not in AMBIGUOUS}

# Length units in a metre by the units code of data set 164
LENGTH_FACTORS = {1: 1.0, 2: 3.28084, 3: 1.0, 4: 3.28084, 5: 1e3, 6: 1e2, 7: 39.37, 8: 1e3, 10: 1e3}

SUPERSCRIPTS = str.maketrans("⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻", "0123456789+-")
# What stands for a sign: ý is ² of MS-DOS read as Latin-1
SIGNS = str.maketrans({"·": "*", "⋅": "*", "•": "*", "∙": "*", "×": "*", "−": "-", "ý": "²"})
GRAVITIES = re.compile(r"(?<![A-Za-z])[gG](_?n|_?0|ₙ|₀)(?![A-Za-z])")
RMS = re.compile(r"[\s_-]*(\(\s*rms\s*\)|\[\s*rms\s*\]|rms)", re.IGNORECASE)
TOKEN = re.compile(r"\s*([A-Za-zµμ%]+(?:'s)?|[+-]?\d+|[-+^*./()\[\]{}])\s*")
CLOSING = {"(": ")", "[": "]", "{": "}"}
WHOLE = re.compile(r"[+-]?[1-9]")


def unit_of_label(label: str) -> Unit:
    """Return the unit that the label of an axis states.

    Raises
    ------
    UnitError
        If a name is unknown, or the label no product of powers.

    Examples
    --------
    >>> unit_of_label("mm2/s4/Hz")
    Unit(factor=1e-06, length=2, mass=0, time=-3)
    >>> unit_of_label("[g rms]²/Hz").dimension
    (2, 0, -3)
    """
    tokens = _tokens(label)
    unit = _product(tokens)
    if tokens:
        raise UnitError(f"{tokens[0]!r} is not expected")
    return unit


def unit_system(code: float, length: float, force: float) -> tuple[Unit, Unit]:
    """Return the units of length and force of a data set 164, which has their numbers in SI.

    Raises
    ------
    UnitError
        If the numbers contradict the units code.
    """
    expected = LENGTH_FACTORS.get(int(code), length)
    if not (
        0.99 < length < math.inf and 0 < force < math.inf and abs(length / expected - 1) < 1e-3
    ):
        message = f"{length:g} units of length in a metre and {force:g} of force in a newton"
        raise UnitError(f"{message} contradict units code {int(code)}")
    return Unit(1 / length, 1), Unit(1 / force, 1, 1, -2)


def contradicts(label: str, units: Iterable[Unit]) -> bool:
    """Return whether a label has another unit of length or force than those of a system."""
    factors = {unit.dimension: unit.factor for unit in units}
    named = map(_unit, filter(str.isalpha, _tokens(label)))
    return any(
        not math.isclose(unit.factor, factors.get(unit.dimension, unit.factor), rel_tol=1e-3)
        for unit in named
    )


def _tokens(label: str) -> list[str]:
    text = label.strip().translate(SIGNS).replace("**", "^")
    text = RMS.sub("", GRAVITIES.sub("g", text))
    text = re.sub("[⁰¹²³⁴-⁹⁺⁻]+", lambda run: f"^{run[0].translate(SUPERSCRIPTS)}", text)
    text = re.sub(r"\^\(([+-]?\d+)\)", r"^\1", text)
    tokens, end = [], 0
    while end < len(text):
        match = TOKEN.match(text, end)
        if match is None:
            raise UnitError(f"{text[end]!r} is not expected")
        tokens.append(match[1])
        end = match.end()
    return tokens


def _product(tokens: list[str]) -> Unit:
    """Return the product up to a closing bracket or the end; take its tokens away."""
    unit, operator, has_slash = DIMENSIONLESS, "*", False
    while True:
        factor = _power(tokens)
        unit = unit.divide(factor) if operator == "/" else unit.multiply(factor)
        if not tokens or tokens[0] in CLOSING.values():
            return unit
        operator = tokens.pop(0) if tokens[0] in "*./" else "*"
        if operator != "/" and has_slash:
            raise UnitError("a product after / needs brackets")
        has_slash = has_slash or operator == "/"


def _power(tokens: list[str]) -> Unit:
    token = tokens.pop(0) if tokens else ""
    if token in CLOSING:
        unit = _product(tokens)
        if not tokens or tokens.pop(0) != CLOSING[token]:
            raise UnitError(f"{token} is not closed")
    else:
        unit = DIMENSIONLESS if token == "1" else _unit(token)
    is_marked = bool(tokens) and tokens[0] == "^"
    if is_marked:
        tokens.pop(0)
    if tokens and WHOLE.fullmatch(tokens[0]):
        return unit.power(int(tokens.pop(0)))
    if is_marked:
        raise UnitError("a power must be a whole number")
    return unit


def _unit(name: str) -> Unit:
    unit = UNITS.get(name) or CAPITALS.get(name)
    if unit is None:
        raise UnitError(f"{name!r} is not a known unit" if name else "a unit is missing")
    return unit
