"""The claims of a study tested against its numbers.

A claim is decided only where the numbers are further apart than `SIGNIFICANCE` of their standard
errors, and not at all where no errors are known.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from pidpanel.arrays import Array
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.panel.basis import PanelBasis
from pidpanel.report.html import Fragment
from pidpanel.report.names import Claim, Scenario, Study, family_of
from pidpanel.report.rms import band_error_of, band_rms_of, moving_points, rms_by
from pidpanel.report.text import value_text
from pidpanel.response.trust import SIGNIFICANCE
from pidpanel.solve.bands import reduction

Finding = tuple[str, str]  # whether a claim holds, and the numbers behind it, in words


class Responses(NamedTuple):
    """Responses of scenarios and of the bare panel at their levels, with one damping model.

    Arrays are (n_scenarios, n_bands or n_motions, n_points).
    """

    summary: pd.DataFrame
    psd: xr.Dataset
    points: Sequence[str]
    scenarios: Mapping[str, Scenario]

    def labels(self, *, is_bare: bool = False) -> dict[object, str]:
        """Return the labels of the scenarios, or of the bare panel at their levels."""
        return {row: (s.bare if is_bare else s).label for row, s in self.scenarios.items()}

    def table(self, column: str, *, is_bare: bool = False) -> pd.DataFrame:
        """Return a column of the summary, with a row per scenario and a column per point."""
        labels = self.labels(is_bare=is_bare)
        return rms_by(self.summary, labels, self.points, column)

    def bands(self, *, is_bare: bool = False) -> tuple[Array, Array]:
        """Return the centres of the third octaves [Hz] and their rms accelerations."""
        labels = list(self.labels(is_bare=is_bare).values())
        return band_rms_of(self.psd, labels, self.points)

    def motions(self, *, is_bare: bool = False) -> Array:
        """Return g rms and displacement with stretching; linear where there is none."""
        motions = []
        for name in ("acceleration_rms_g", "displacement_rms_mm"):
            stretched = self.table(f"stretched_{name}", is_bare=is_bare)
            motions.append(stretched.fillna(self.table(name, is_bare=is_bare)).to_numpy(float))
        return np.stack(motions, axis=1)


def decided(margin: ArrayLike, error: ArrayLike) -> str:
    """Return whether all margins are positive beyond their errors, in words.

    Examples
    --------
    >>> decided([3.0, 1.0], 0.1), decided([3.0, -1.0], 0.1), decided([3.0, 0.1], 0.1)
    ('holds', 'does not hold', 'within the errors')
    """
    distance, spread = np.broadcast_arrays(np.asarray(margin, float), np.asarray(error, float))
    if not np.isfinite(spread).all():
        return "no error, not judged"
    if (distance > SIGNIFICANCE * spread).all():
        return "holds"
    return "does not hold" if (distance < -SIGNIFICANCE * spread).any() else "within the errors"


def leads(gained: pd.DataFrame, error: pd.DataFrame, chosen: "pd.Series[Any]") -> Finding:
    """Test whether the chosen row of each column has the largest reduction."""
    margins, errors, parts = [], [], []
    for column, row in chosen.items():
        gains, spread = gained[str(column)], error[str(column)]
        rival: Any = gains.drop(row).idxmax()
        margins.append(gains[row] - gains[rival])
        errors.append(math.hypot(spread[row], spread[rival]))
        first, second = (row, rival) if margins[-1] > 0 else (rival, f"{row} (claimed)")
        ahead = f"{value_text(abs(margins[-1]), errors[-1])} dB more than {second}"
        parts.append(f"{column}: {gains[first]:.2f} dB, {first}, {ahead}")
    return decided(margins, errors), "; ".join(parts)


def is_alike(gained: pd.DataFrame, error: pd.DataFrame, limit: float) -> Finding:
    """Test whether the reductions are within a limit [dB] of each other at every point."""
    spread, errors, parts = gained.max() - gained.min(), [], []
    for point, gains in gained.items():
        most, least = str(gains.idxmax()), str(gains.idxmin())
        errors.append(math.hypot(error[str(point)][most], error[str(point)][least]))
        parts.append(f"{point}: {value_text(spread[str(point)], errors[-1])} dB")
    evidence = f"spread {'; '.join(parts)} (the same below {limit:g} dB)"
    return decided(limit - spread, errors), evidence


def gains_at_high_frequency(gained: Array, error: Array, centre: Array) -> Finding:
    """Test whether the reduction [dB] is larger in the upper half of the bands than in the lower.

    Errors are common to the bands of a half.
    """
    half = len(centre) // 2
    lower, upper = gained[:, :half].mean(axis=1), gained[:, half:].mean(axis=1)
    spread = np.hypot(error[:, :half].mean(axis=1), error[:, half:].mean(axis=1))
    evidence = (
        f"in {(upper > lower).sum()} of {lower.size} responses; mean over the third octaves from "
        f"{centre[half]:.0f} Hz {upper.mean():.2f} dB, below {lower.mean():.2f} dB"
    )
    return decided(upper - lower, spread), evidence


def rises(oaspl: Sequence[float], rms: Array, bare: Array, error: Array, limit: float) -> Finding:
    """Test whether motions rise by as many dB as the sound, within a limit [dB]."""
    order = np.argsort(oaspl)
    level = np.asarray(oaspl)[order]
    rise, bare_rise = (np.diff(20 * np.log10(values[order]), axis=0) for values in (rms, bare))
    parts = [
        f"{low:g} to {high:g} dB: {part.min():.2f} to {part.max():.2f} dB, "
        f"the bare panel {plain.min():.2f} to {plain.max():.2f} dB"
        for low, high, part, plain in zip(level[:-1], level[1:], rise, bare_rise, strict=True)
    ]
    margin = limit - np.abs(rise - np.diff(level)[:, None, None])
    evidence = f"rise from {'; from '.join(parts)} (linear within {limit:g} dB)"
    return decided(margin, np.hypot(error[order][1:], error[order][:-1])), evidence


def finding_of(claim: Claim, responses: Responses, distance: pd.DataFrame, row: str) -> Finding:
    """Test a claim; ``row`` is the scenario of its first value.

    The verdict follows the rms acceleration, which the lowest modes dominate; the evidence also
    names the most effective scenario by the mean over third octaves.
    """
    rms, bare_rms = (
        responses.table("acceleration_rms_g", is_bare=is_bare) for is_bare in (False, True)
    )
    if not np.isfinite(rms.to_numpy(float)).all():
        return "cannot be tested", "no steady response"
    gained = pd.DataFrame(reduction(bare_rms, rms), rms.index, rms.columns)
    error = responses.table("reduction_error_db")
    (centre, bands), (_, bare) = responses.bands(), responses.bands(is_bare=True)
    labels = list(responses.labels().values())
    errors = band_error_of(responses.psd, labels, responses.points)
    match claim.comparison:
        case "nearest_patch":
            return leads(gained, error, distance.idxmin())
        case "nearest_point":
            return leads(gained.T, error.T, distance.T.idxmin())
        case "most_effective":
            verdict, evidence = leads(gained, error, pd.Series(row, gained.columns))
            mean = pd.DataFrame(reduction(bare, bands).mean(axis=1), rms.index, rms.columns)
            best = "; ".join(f"{p}: {mean[p].idxmax()}, {mean[p].max():.2f} dB" for p in mean)
            return verdict, f"{evidence}. In the mean over third octaves {best}"
        case "lowered":
            values = gained.to_numpy()
            ends = f"{values.min():.2f} to {values.max():.2f} dB"
            evidence = f"{(values > 0).sum()} of {values.size} lowered, by {ends}"
            return decided(values, error), evidence
        case "alike":
            return is_alike(gained, error, claim.alike_db)
        case "high_frequency":
            return gains_at_high_frequency(reduction(bare, bands), errors, centre)
        case "linear_stretched":
            bands, bare = responses.motions(), responses.motions(is_bare=True)
            errors = np.repeat(error.to_numpy(float)[:, None], 2, axis=1)
    oaspl = [float(scenario.oaspl_db or math.nan) for scenario in responses.scenarios.values()]
    return rises(oaspl, bands, bare, errors, claim.alike_db)


def verdicts(
    study: Study, summary: pd.DataFrame, psd: xr.Dataset, distance: pd.DataFrame
) -> Iterator[dict[str, Any]]:
    """Test every claim of a study with each damping model; ``distance`` is `patch_distance`."""
    points = moving_points(summary, list(study.panel.points))
    families = [(claim, family_of(study, claim.scenarios)) for claim in study.claims if points]
    cases = [(claim, family, model) for claim, family in families for model in family.groups]
    for claim, (_, _, varied, _, groups), model in cases:
        scenarios = {s.label if varied == "oaspl_db" else s.name: s for s in groups[model]}
        key = "dampers" if varied == "damper" else varied
        rows = [row for row, s in scenarios.items() if getattr(s, key) in claim.values]
        if rows and claim.comparison != "most_effective":
            scenarios = {row: scenarios[row] for row in rows}
        patches = [str(scenario.patch) for scenario in scenarios.values()]
        distances = distance.reindex(patches, columns=points).set_axis(list(scenarios))
        responses = Responses(summary, psd, points, scenarios)
        finding = "cannot be tested", "only one point moves"
        if len(points) > 1 or claim.comparison != "nearest_point":
            finding = finding_of(claim, responses, distances, next(iter(rows), ""))
        shown = claim if model == next(iter(groups)) else None
        yield {"claim": shown, "model": model, "verdict": finding[0], "evidence": finding[1]}


def patch_distance(basis: PanelBasis) -> pd.DataFrame:
    """Return distances [m] between patch centres (index) and points (columns)."""
    corners = basis.vertex_position[basis.cells]
    weight = basis.cell_in_patch * cell_areas(basis.vertex_position, basis.cells)
    centre = weight @ corners.mean(axis=1) / weight.sum(axis=1, keepdims=True)
    distance = np.linalg.norm(centre[:, None] - basis.point_position, axis=-1)
    return pd.DataFrame(distance, basis.patch_names, basis.point_names)


def verdict_table(rows: Sequence[Mapping[str, Any]]) -> Fragment | None:
    """Return the claims with the verdicts of all damping models; None without claims."""
    return Fragment("claims.html", {"rows": rows, "significance": SIGNIFICANCE}) if rows else None
