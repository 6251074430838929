"""Which numbers of ``summary.csv`` are to be trusted, why not, and the source of the damping."""

import math
from collections.abc import Hashable, Mapping, Sequence
from typing import Any

import pandas as pd

from pidpanel.response.cases import ResponseScenario
from pidpanel.solve.mesh_error import ALLOWED_DB, ALLOWED_RMS

# Share of the power input that may be unaccounted for: a PSD cannot be read more finely.
POWER_BALANCE = 1e-3

# |ln(Γ_out/Γ)| from which a motion is not converged: rms values are good to 1e-3.
MOTION_RESIDUAL = 1e-3

BASIS_ERROR = 5e-3  # error of a PSD that the shapes of the panel may leave (README)
MODES_ERROR = 0.05  # likewise of the modes of a file: 2.5 % of g rms, with a margin of 1.5

# Error of a PSD at any line, and of an rms acceleration, that the mesh may make.
MESH_ERROR, MESH_RMS = 10 ** (ALLOWED_DB / 10) - 1, ALLOWED_RMS

COARSE_MESH = "mesh too coarse"

# Change of an rms acceleration with elements of half the size, due to single points, from which
# it is doubted: 0.4 dB.
POINT_RMS = 0.05
AT_POINTS = "held at single points"

# Share of the change in mean square that may rest on damping a factor of two beyond its data.
EXTRAPOLATED_SHARE = 0.05

NOT_LINEAR, EXTRAPOLATED, NO_ERROR = "not linear", "extrapolated", "no stated error"

# Change of g rms by stretching from which linear values are doubted: 0.4 dB. The displacement
# changes more; its table has both.
STRETCHED = 0.05
COARSE_SWEEP = "coarse sweep"
KNOWN_TO = "known to"

# Share of the change in mean square at lines where beds of the atlas may ride or cross their gap,
# above which the page mentions it. The errors are calibrated there, so it is no doubt.
BETWEEN_SHARE = 0.2
MAY_CROSS = "beds may ride or cross their gap"

SIMULATED = " (model: coupled)"  # remedy for a large error of the atlas

TOO_FAR = 2.0  # standard error of a coupled g rms over the required one, above which it is doubted

# Relative standard error of g rms from which other damping is doubted, 2 dB, and the atlas, which
# coupled runs can replace [1].
LARGEST_ERROR, LARGEST_OF_ATLAS = 0.25, 0.08

# Standard errors above which a difference is significant (95 % of a normal distribution).
SIGNIFICANCE = 2.0

BETWEEN = "; "  # between the doubts of a scenario

TRUST = ["trusted", "doubts", "damping_source"]  # columns of `judged`


def judged(
    scenarios: Sequence[ResponseScenario],
    summary: pd.DataFrame,
    coupled_accuracy: float,
    basis_error: float = BASIS_ERROR,
) -> pd.DataFrame:
    """Return ``summary.csv`` with the columns ``trusted``, ``doubts`` and ``damping_source``.

    Parameters
    ----------
    scenarios
        Scenarios of the study.
    summary
        Rows of the scenarios, one for each point.
    coupled_accuracy
        Required relative standard error of coupled rms accelerations [1].
    basis_error
        Largest error of a PSD that the shapes may leave [1].
    """
    by_label = {scenario.label: scenario for scenario in scenarios}
    reasons: dict[Hashable, list[str]] = {}
    for key, rows in summary.groupby("scenario", sort=False):
        scenario = by_label[str(key)]
        point_rows = [{str(k): v for k, v in row.items()} for row in rows.to_dict("records")]
        moving = [row for row in point_rows if row["status"] == "ok"]
        if not moving:
            reasons[key] = [str(point_rows[0]["status"])]
            continue
        if scenario.is_coupled:
            remedy = " (more damping.coupled.runs)"
            error = TOO_FAR * coupled_accuracy
            reasons[key] = doubts(moving, error, remedy, basis_error)
        else:
            error = math.inf if scenario.is_bare else LARGEST_ERROR
            error, remedy = (LARGEST_OF_ATLAS, SIMULATED) if scenario.is_of_atlas else (error, "")
            reasons[key] = doubts(moving, error, remedy, basis_error)
            reasons[key] += [COARSE_SWEEP] * scenario.is_coarse
    keys = summary["scenario"].tolist()
    return summary.assign(
        trusted=["no" if reasons[key] else "yes" for key in keys],
        doubts=[BETWEEN.join(reasons[key]) for key in keys],
        damping_source=[by_label[key].source for key in keys],
    )


def doubts(
    rows: Sequence[dict[str, Any]],
    largest_error: float,
    remedy: str = "",
    basis_error: float = BASIS_ERROR,
) -> list[str]:
    """Return the reasons not to trust the results of a scenario; none if they can be trusted.

    Parameters
    ----------
    rows
        Rows of the scenario in ``response/summary.csv``, one for each moving point.
    largest_error
        Largest allowed relative standard error of rms accelerations [1]; inf for the bare panel.
    remedy
        Remedy for a larger error, added to the text.
    basis_error
        Same as in `judged`.
    """
    first, reasons = rows[0], []
    if any(row["beyond_linear_plate"] is True or row["beyond_linear_plate"] == 1 for row in rows):
        reasons += _stretching(rows)
    share = max(row["extrapolated_share"] for row in rows)
    if share > EXTRAPOLATED_SHARE:
        advice = f"extend {first['data_missing']}"
        reasons.append(f"{100 * share:.0f} % of the change {EXTRAPOLATED}, {advice}")
    if first["levels"] > 1:
        reasons.append("several solutions")
    if first["motion_residual"] > MOTION_RESIDUAL:
        reasons.append("motion not converged")
    if first.get("basis_error", 0.0) > basis_error:
        reasons.append("basis too small")
    reasons += mesh_doubts(rows)
    if math.isfinite(largest_error):
        error = max((_relative_error(row) for row in rows), default=0.0)
        if not math.isfinite(error):
            reasons.append(NO_ERROR)
        elif error > largest_error:
            reasons.append(f"{KNOWN_TO} ± {100 * error:.2g} % only{remedy}")
    return reasons


def mesh_doubts(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the reasons not to trust rows that the mesh has, under sound or base motion."""
    reasons = []
    if largest(rows, "mesh_error") > MESH_ERROR or largest(rows, "mesh_error_rms") > MESH_RMS:
        reasons.append(COARSE_MESH)
    if largest(rows, "point_error_rms") > POINT_RMS:
        reasons.append(AT_POINTS)
    return reasons


def judged_base(table: pd.DataFrame, keys: Sequence[str]) -> pd.DataFrame:
    """Return a table of base motion with the columns ``trusted`` and ``doubts`` of each case.

    ``keys`` are the columns that make a case; its rows are those of the points.
    """
    doubts_of_case: dict[Hashable, str] = {}
    for key, rows in table.groupby(list(keys), sort=False):
        records = [{str(k): v for k, v in row.items()} for row in rows.to_dict("records")]
        status = records[0].get("status", "ok")
        reasons = mesh_doubts(records) if status == "ok" else [str(status)]
        doubts_of_case[key] = BETWEEN.join(reasons)
    reasons = [doubts_of_case[key] for key in table[list(keys)].itertuples(index=False, name=None)]
    return table.assign(trusted=["no" if r else "yes" for r in reasons], doubts=reasons)


def _stretching(rows: Sequence[Mapping[str, Any]]) -> list[str]:
    """Return the doubt of a panel that stretches, with the largest change of g rms at a point."""
    changes = []
    for row in rows:
        linear, stretched = (row.get(f"{word}acceleration_rms_g") for word in ("", "stretched_"))
        if stretched is None or not math.isfinite(stretched):
            return [NOT_LINEAR]
        if linear:
            error = row["stretched_acceleration_rms_error_g"] / linear
            changes.append((stretched / linear - 1, error))
    change, error = max(changes, key=lambda pair: abs(pair[0]))
    if abs(change) <= STRETCHED:
        return []
    amount = f"{100 * change:+.2g} ± {100 * error:.1g} %".replace("-", "−")
    return [f"{NOT_LINEAR}, stretching changes g rms by {amount}"]


def largest(rows: Sequence[Mapping[str, Any]], column: str) -> float:
    """Return the largest value of a column; 0 where there is none."""
    return max((row.get(column, 0.0) for row in rows), default=0.0)


def _relative_error(row: Mapping[str, Any]) -> float:
    """Return that of the rms acceleration [1]; 0 where nothing moves."""
    rms = row["acceleration_rms_g"]
    return row.get("acceleration_rms_error_g", math.nan) / rms if rms > 0 else 0.0


def doubts_in(row: Mapping[str, Any]) -> tuple[str, ...]:
    """Return the doubts in a row of ``summary.csv``.

    Examples
    --------
    >>> doubts_in({"doubts": "not linear; several solutions"}), doubts_in({"doubts": math.nan})
    (('not linear', 'several solutions'), ())
    """
    reasons = row.get("doubts")
    return tuple(reasons.split(BETWEEN)) if isinstance(reasons, str) and reasons else ()
