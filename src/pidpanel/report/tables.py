"""Rows of text from frames of numbers, with the units in the heads of the columns."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.report.findings import Verdict
from pidpanel.report.html import Table

READINGS = {
    "dem": "DEM",
    "paper_corrected": "The paper's law, corrected",
    "paper_printed": "The paper's law, as printed",
    "table": "The study's table",
}
"""What the readings of the damping are called on the page."""

PRINTED_ROUNDING = 2e-4
"""Relative difference up to which a frequency counts as the printed one: Table 1 has two
decimals (8e-5 of the lowest) and the panel is the paper's within that or it is not."""

_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")


def number(value: float, digits: int = 3) -> str:
    """A number with so many significant digits, a power of ten outside 1e-4 to 1e5.

    Examples
    --------
    >>> number(0.123456), number(1234.5), number(9.4e-9), number(float("nan"))
    ('0.123', '1234', '9.40·10⁻⁹', '–')
    """
    if not math.isfinite(value):
        return "–"
    if value != 0 and not 1e-4 <= abs(value) < 1e5:
        mantissa, exponent = f"{value:.{digits - 1}e}".split("e")
        return f"{mantissa}·10{str(int(exponent)).translate(_SUPERSCRIPT)}"
    decimals = max(0, digits - 1 - (math.floor(math.log10(abs(value))) if value else 0))
    return f"{value:.{decimals}f}"


def with_error(value: float, error: float) -> str:
    """Value ± standard error, both to two digits of the error.

    Examples
    --------
    >>> with_error(495.3, 12.3), with_error(0.4567, 0.0231)
    ('495 ± 12', '0.457 ± 0.023')
    """
    if not (math.isfinite(value) and math.isfinite(error)):
        return "–"
    if error <= 0:
        return number(value)
    decimals = max(0, 1 - math.floor(math.log10(error)))
    return f"{value:.{decimals}f} ± {error:.{decimals}f}"


def records(frame: pd.DataFrame) -> list[dict[str, Any]]:
    """The rows of a frame by the names of its columns."""
    return [dict(zip(frame.columns, row, strict=True)) for row in frame.itertuples(index=False)]


# --------------------------------------------------------------------------- panel


def is_papers_panel(modes: pd.DataFrame, printed: pd.DataFrame) -> bool:
    """Whether closed form and printed table speak of one panel.

    Parameters
    ----------
    modes
        ``panel/modes.csv``.
    printed
        ``workflow/data/paper/table_1.csv``.
    """
    if "navier_hz" not in modes:
        return False
    both = printed.merge(modes, on=["m", "n"], suffixes=("_printed", ""))
    if len(both) < len(printed):
        return False
    away = np.abs(both["navier_hz"] / both["frequency_hz_printed"] - 1)
    return bool((away < PRINTED_ROUNDING).all())


def paper_mode_tables(modes: pd.DataFrame, printed: pd.DataFrame) -> list[Table]:
    """Table 1 row by row beside what was computed, and the modes that it leaves out.

    Parameters and precondition: `is_papers_panel`.
    """
    both = printed.merge(modes, on=["m", "n"], suffixes=("_printed", ""), how="left")
    rows = [
        [
            f"({row['m']}, {row['n']})",
            f"{row['frequency_hz_printed']:.2f}",
            f"{row['frequency_hz']:.2f}",
            f"{row['navier_hz']:.2f}",
            f"{100 * (row['frequency_hz'] / row['frequency_hz_printed'] - 1):+.4f}",
        ]
        for row in records(both)
    ]
    columns = ["mode (m, n)", "printed, Hz", "computed, Hz", "closed form (Navier), Hz"]
    worst = (both["frequency_hz"] / both["frequency_hz_printed"] - 1).abs().max()
    first = Table(
        f"Table 1 of the paper, all {len(printed)} rows in the printed order; the computed "
        f"frequencies differ from the printed ones by at most {100 * worst:.3f} %",
        [*columns, "computed − printed, %"],
        rows,
    )
    # to the next hundred above the last printed frequency
    limit = 100 * math.ceil(printed["frequency_hz"].max() / 100)
    listed = pd.MultiIndex.from_frame(printed[["m", "n"]])
    left_out = ~pd.MultiIndex.from_frame(modes[["m", "n"]]).isin(listed)
    missing = modes[(modes["frequency_hz"] < limit) & left_out]
    second = Table(
        f"The {len(missing)} modes below {limit} Hz that the table leaves out",
        [columns[0], *columns[2:]],
        [
            [f"({row['m']}, {row['n']})", f"{row['frequency_hz']:.2f}", f"{row['navier_hz']:.2f}"]
            for row in records(missing)
        ],
    )
    return [first, second]


def mode_table(modes: pd.DataFrame, *, folded: bool = False) -> Table:
    """All modes, with their orders and closed forms where they have them.

    Parameters
    ----------
    modes
        ``panel/modes.csv``.
    folded
        Whether to hide the rows behind the caption.
    """
    columns: list[tuple[str, Callable[[dict[str, Any]], str]]] = [
        ("mode", lambda row: str(row["mode"]))
    ]
    if "m" in modes:
        columns.append(("(m, n)", lambda row: f"({row['m']}, {row['n']})"))
    columns.append(("computed, Hz", lambda row: f"{row['frequency_hz']:.2f}"))
    if "navier_hz" in modes:
        columns.append(("closed form (Navier), Hz", lambda row: f"{row['navier_hz']:.2f}"))
    columns.append(("modal mass, kg", lambda row: f"{row['modal_mass_kg']:.4f}"))
    return Table(
        f"All {len(modes)} modes of the panel",
        [name for name, _ in columns],
        [[shown(row) for _, shown in columns] for row in records(modes)],
        folded=folded,
    )


# --------------------------------------------------------------------------- coupon


def case_table(cases: pd.DataFrame, varied: Sequence[str] = ()) -> Table:
    """Every case of the coupon with its errors and its status.

    Parameters
    ----------
    cases
        ``coupon/cases.csv``.
    varied
        Further columns that tell the cases apart.
    """
    columns = [
        *varied, "r", "f, Hz", "Γ, g", "E_d, J/m²", "C_e, N s/m³", "m_a, kg/m²", "η",
        "share of bound", "spheres a cell", "modulus, MPa", "cycles run (used)",
        "error as asked", "energy missing, %", "lost along normal, %", "status",
    ]  # fmt: skip
    rows = [
        [
            *(str(row[key]) for key in varied),
            f"{row['fill_fraction']:g}",
            f"{row['frequency_hz']:g}",
            f"{row['acceleration_g']:g}",
            with_error(row["dissipated_energy_j_m2"], row["dissipated_energy_error_j_m2"]),
            with_error(row["equivalent_damping_n_s_m3"], row["equivalent_damping_error_n_s_m3"]),
            with_error(row["apparent_mass_kg_m2"], row["apparent_mass_error_kg_m2"]),
            number(row["loss_factor"]),
            number(row["share_of_bound"], 2),
            number(row["spheres_per_cell"]),
            f"{row['youngs_modulus_mpa']:g}",
            f"{row['cycles_run']} ({row['cycles_used']})",
            "yes" if row["target_met"] else "no",
            number(100 * row["closure"], 2),
            number(100 * row["normal_share"], 2),
            row["status"],
        ]
        for row in records(cases)
    ]
    good = int((cases["status"] == "ok").sum())
    return Table(
        f"All {len(cases)} cases, {good} of them ok; errors are one standard error",
        columns,
        rows,
        folded=True,
    )


# --------------------------------------------------------------------------- response


def response_table(summary: pd.DataFrame, scenarios: Sequence[str], points: Sequence[str]) -> Table:
    """Scenario by point: rms values and reduction, the readings side by side.

    Parameters
    ----------
    summary
        ``response/summary.csv``: one row a reading, scenario and point (points as text).
    scenarios, points
        In the order wanted.
    """
    readings = list(dict.fromkeys(summary["reading"]))
    columns = ["scenario", "point"]
    for reading in readings:
        name = READINGS.get(reading, reading)
        columns += [f"{name}: a rms, g", "w rms, mm", "reduction, dB", "C_e read at Γ, g"]
    by_key = {(row["scenario"], row["point"], row["reading"]): row for row in records(summary)}
    rows = []
    for scenario in scenarios:
        for point in points:
            row = [scenario, point]
            for reading in readings:
                one = by_key[scenario, point, reading]
                if one["status"] != "ok":
                    row += [str(one["status"]), "–", "–", "–"]
                    continue
                row += [
                    _maybe_with_error(one, "acceleration_rms_g", "acceleration_rms_error_g"),
                    number(one["displacement_rms_mm"]) + " †" * bool(one["beyond_linear_plate"]),
                    _maybe_with_error(one, "reduction_db", "reduction_error_db"),
                    number(one["damping_read_at_g"])
                    + " ‡" * bool(one["outside_run_points_share"] > 0),
                ]
            rows.append(row)
    return Table(
        "Rms over the frequencies looked at, and the reduction against the bare panel under the "
        "same sound; ±: one standard error by that of C_e and m_a. † beyond linear plate theory "
        "(w rms above a tenth of the thickness); ‡ partly "
        "outside the run points of the coupon.",
        columns,
        rows,
    )


def _maybe_with_error(row: dict[str, Any], value: str, error: str) -> str:
    """The value of a row, with its error where it has one."""
    own = row.get(error, math.nan)
    return with_error(row[value], own) if own > 0 else number(row[value])


def verdict_table(verdicts: Sequence[Verdict]) -> Table | None:
    """The claims, each once with all its readings, and what the numbers say; None for none."""
    if not verdicts:
        return None
    rows = []
    for verdict in verdicts:
        if verdict.finding is None:
            answer, evidence = "cannot be said", verdict.reason
        else:
            answer = "holds" if verdict.finding.holds else "does not hold"
            evidence = verdict.finding.evidence
        rows.append([verdict.claim, READINGS[verdict.reading], answer, evidence])
    claims = list(dict.fromkeys(verdict.claim for verdict in verdicts))
    rows.sort(key=lambda row: claims.index(row[0]))
    for before, row in reversed(list(pairwise(rows))):
        row[0] = "" if row[0] == before[0] else row[0]
    return Table(
        "The paper's claims against these numbers",
        ["claim", "reading", "verdict", "evidence (rms acceleration)"],
        rows,
    )
