"""Measured points on the page of a coupon, compared with simulated cases and the atlas."""

from collections.abc import Mapping, Sequence
from itertools import combinations
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.figure import Figure
from matplotlib.lines import Line2D

from pidpanel.damping.measured import SOURCES
from pidpanel.damping.table_files import DAMPING, MASS
from pidpanel.report import layout, style
from pidpanel.report.coupon_figures import ACCELERATION, FREQUENCY
from pidpanel.report.html import PageSection, figure_picture, template_section
from pidpanel.report.text import records
from pidpanel.response.trust import SIGNIFICANCE

QUANTITIES = {DAMPING: ("Cₑ", "N s/m³"), MASS: ("mₐ", "kg/m²")}
LOOKS: Mapping[str, Mapping[str, Any]] = {
    "measured": {"marker": "o", "ls": "none"},
    "simulated": {"marker": "s", "mfc": "none", "ls": "none"},
    "atlas": {"marker": "_", "ls": "--"},
}


def measured_section(compared: pd.DataFrame, varied: Sequence[str] = ()) -> PageSection:
    """Return measured values, those of cases and of the atlas, and their differences.

    Parameters
    ----------
    compared
        Table returned by `measured.compared`.
    varied
        Columns by which simulated cases differ besides; only the values nearest are shown.
    """
    variants = compare_variants(compared, varied) if varied else []
    if variants:
        compared = variants[0]["rows"]
    values = {
        "variants": variants,
        "close": sum(0 < variant.get("z", 0.0) < SIGNIFICANCE for variant in variants),
        "sources": [agreement(compared, source) for source in SOURCES[1:]],
        "drawing": figure_picture("measured", measured_figure, compared),
        "quantities": [
            {"name": name, "unit": unit, "rows": _rows(compared, column)}
            for column in _given(compared)
            for name, unit in (QUANTITIES[column],)
        ],
    }
    return template_section("measured.html", "Measured, simulated, atlas", values)


def compare_variants(compared: pd.DataFrame, varied: Sequence[str]) -> list[dict[str, Any]]:
    """Return the `agreement` of measured points with each variant, the nearest first.

    That is the one whose C_e differs least, of those with the most measured points.
    """
    variants = []
    for _, rows in compared.groupby(list(varied), sort=False):
        values = {key: rows[key].iloc[0] for key in varied}
        variants.append({"values": values, "rows": rows, **agreement(rows, "simulated")})
    return sorted(variants, key=lambda variant: (-variant["points"], variant.get("rms", 0.0)))


def _given(compared: pd.DataFrame) -> list[str]:
    return [name for name in QUANTITIES if compared[f"measured_{name}"].notna().any()]


def agreement(compared: pd.DataFrame, source: str) -> dict[str, Any]:
    """Return in how many points there is a measured C_e and one of a source, and their ratio.

    ``ratio`` is the geometric mean of measured over the other, ``rms`` that of its logarithm, ``z``
    that of the difference over the standard error of both; 0 where no error is given.
    """
    pairs = compared[(compared[f"measured_{DAMPING}"] > 0) & (compared[f"{source}_{DAMPING}"] > 0)]
    if pairs.empty:
        return {"name": source, "points": 0}
    difference, error = _difference(pairs, ("measured", source), DAMPING)
    logarithm = np.log(pairs[f"measured_{DAMPING}"] / pairs[f"{source}_{DAMPING}"])
    z = (difference / error)[error > 0]
    return {
        "name": source,
        "points": len(pairs),
        "ratio": float(np.exp(logarithm.mean())),
        "rms": float(np.sqrt((logarithm**2).mean())),
        "z": float(np.sqrt((z**2).mean())) if len(z) else 0.0,
    }


def _difference(
    compared: pd.DataFrame, sources: tuple[str, str], quantity: str
) -> tuple[pd.Series, pd.Series]:
    """Return the difference of two sources and its standard error; a missing error is 0."""
    first, second = (compared[f"{source}_{quantity}"] for source in sources)
    errors = [compared[f"{source}_{quantity}_error"].fillna(0.0) for source in sources]
    return first - second, (errors[0] ** 2 + errors[1] ** 2) ** 0.5


def _rows(compared: pd.DataFrame, quantity: str) -> list[dict[str, Any]]:
    """Return rows with (head, value, standard error) of all sources and their differences."""
    columns = {
        source: (
            compared[f"{source}_{quantity}"],
            compared[f"{source}_{quantity}_error"].fillna(0.0),
        )
        for source in SOURCES
    }
    for pair in combinations(SOURCES, 2):
        columns[" − ".join(pair)] = _difference(compared, pair, quantity)
    return [
        {
            **row,
            "sources": [
                (name, value.iloc[index], error.iloc[index])
                for name, (value, error) in columns.items()
            ],
        }
        for index, row in enumerate(records(compared))
    ]


def measured_figure(compared: pd.DataFrame) -> Figure:
    """Draw C_e and m_a over frequency or Γ: a column for each fill, a colour for each other."""
    over_g = compared["acceleration_g"].nunique() > compared["frequency_hz"].nunique()
    x, second = (ACCELERATION, FREQUENCY) if over_g else (FREQUENCY, ACCELERATION)
    fills, quantities = sorted(compared["fill_fraction"].unique()), _given(compared)
    levels = list(dict.fromkeys(sorted(compared[second.column])))
    figure = Figure(figsize=(layout.WIDTH, 2.4 * len(quantities) + 0.5), layout="constrained")
    grid = figure.subplots(len(quantities), len(fills), squeeze=False, sharex=True, sharey="row")
    for line, quantity in zip(grid, quantities, strict=True):
        for axes, fill in zip(line, fills, strict=True):
            rows = compared[compared["fill_fraction"] == fill]
            for place, level in enumerate(levels):
                curve = rows[rows[second.column] == level].sort_values(x.column)
                for source, look in LOOKS.items():
                    axes.errorbar(
                        curve[x.column], curve[f"{source}_{quantity}"],
                        yerr=curve[f"{source}_{quantity}_error"].fillna(0.0),
                        color=_colour(place), capsize=1.8, elinewidth=0.7, capthick=0.7, **look,
                    )  # fmt: skip
            layout.log_scale(axes, "xy" if quantity == DAMPING else "x")
            if quantity != DAMPING:
                axes.axhline(0, color="#888888", lw=0.6)
            axes.set_title(f"r = {fill:g}", loc="left")
        line[0].set_ylabel(", ".join(QUANTITIES[quantity]))
    for axes in grid[-1]:
        axes.set_xlabel(x.label)
    handles = {source: Line2D([], [], color=layout.GREY, **look) for source, look in LOOKS.items()}
    handles |= {
        f"{second.symbol} = {level:.4g}": Line2D([], [], color=_colour(place))
        for place, level in enumerate(levels)
    }
    layout.add_legend(figure, 6, handles)
    return figure


def _colour(number: int) -> str:
    return style.PLACES[number % len(style.PLACES)]
