"""The claims of a study tested against its numbers.

A claim is decided only where the numbers are further apart than `SIGNIFICANCE` of their standard
errors, and not at all where no errors are known. `verdicts` tests the claims with each damping
model; `verdict_table` shows the verdicts.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from pidpanel.arrays import Array
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.panel.basis import PanelBasis
from pidpanel.report.answer import SIGNIFICANCE
from pidpanel.report.html import Fragment
from pidpanel.report.names import Scenario, Study
from pidpanel.report.rms import band_error_of, band_rms_of, moving_points, rms_by
from pidpanel.report.text import value_text
from pidpanel.solve.bands import reduction
from pidpanel.study.claims import Claim

WORDS = {"fill_fraction": "r = {:g}", "oaspl_db": "{:g} dB", "patch": "{}"}


class Finding(NamedTuple):
    """Whether a claim holds, and the numbers behind it."""

    holds: bool | None  # None where the numbers do not decide
    evidence: str  # the numbers in words
    has_errors: bool = True  # whether the numbers have errors


class Verdict(NamedTuple):
    """The finding on a claim for one damping model."""

    claim: Claim
    reading: str
    finding: Finding | None  # None without a steady response


def decided(margin: ArrayLike, error: ArrayLike) -> bool | None:
    """Return whether all margins are positive beyond their errors; None if undecided or unknown.

    Examples
    --------
    >>> decided([3.0, 1.0], 0.1), decided([3.0, -1.0], 0.1), decided([3.0, 0.1], 0.1)
    (True, False, None)
    """
    distance, spread = np.broadcast_arrays(np.asarray(margin, float), np.asarray(error, float))
    if not np.isfinite(spread).all():
        return None
    if (distance > SIGNIFICANCE * spread).all():
        return True
    return False if (distance < -SIGNIFICANCE * spread).any() else None


def _finding(margin: ArrayLike, error: ArrayLike, evidence: str) -> Finding:
    return Finding(decided(margin, error), evidence, bool(np.isfinite(np.asarray(error)).all()))


@dataclass(frozen=True)
class Responses:
    """Responses of the scenarios of a claim with one damping model, the lowest level first.

    Tables have a row per scenario, named by what varies, and a column per point that moves. Arrays
    are (n_scenarios, n_bands or n_motions, n_points).
    """

    summary: pd.DataFrame
    psd: xr.Dataset
    reading: str
    points: Sequence[str]
    scenarios: Mapping[str, Scenario]
    distance: pd.DataFrame  # [m] of patches (rows) and points

    def labels(self, *, is_bare: bool = False) -> dict[object, str]:
        """Return the labels of the scenarios, or of the bare panel at their levels, by row."""
        return {row: (s.bare if is_bare else s).label for row, s in self.scenarios.items()}

    def table(self, column: str, *, is_bare: bool = False) -> pd.DataFrame:
        """Return a column of the summary."""
        labels = self.labels(is_bare=is_bare)
        return rms_by(self.summary, self.reading, labels, self.points, column)

    def bands(self, *, is_bare: bool = False) -> tuple[Array, Array]:
        """Return centres of third octaves [Hz] and their rms values."""
        labels = list(self.labels(is_bare=is_bare).values())
        return band_rms_of(self.psd, self.reading, labels, self.points)

    def motions(self, *, is_bare: bool = False) -> Array:
        """Return g rms and displacement with stretching; linear where there is none."""
        motions = []
        for name in ("acceleration_rms_g", "displacement_rms_mm"):
            stretched = self.table(f"stretched_{name}", is_bare=is_bare)
            motions.append(stretched.fillna(self.table(name, is_bare=is_bare)).to_numpy(float))
        return np.stack(motions, axis=1)

    @property
    def gained(self) -> pd.DataFrame:
        """Reductions of the rms acceleration against the bare panel [dB]."""
        rms = self.table("acceleration_rms_g")
        bare = self.table("acceleration_rms_g", is_bare=True)
        return pd.DataFrame(reduction(bare, rms), rms.index, rms.columns)

    @property
    def error(self) -> pd.DataFrame:
        """Standard errors of the reductions [dB]."""
        return self.table("reduction_error_db")

    @property
    def band_gained(self) -> Array:
        """Reductions of the third octaves [dB]."""
        return reduction(self.bands(is_bare=True)[1], self.bands()[1])

    @property
    def band_error(self) -> Array:
        """Standard errors of the levels of the third octaves [dB]."""
        return band_error_of(self.psd, self.reading, list(self.labels().values()), self.points)


def most_effective(claim: Claim, responses: Responses) -> Finding:
    """Test whether a scenario reduces every point most.

    The verdict follows the rms acceleration, which the lowest modes dominate; the evidence also
    names the best by the mean over third octaves, with equal weight for all bands.
    """
    gained, mean = responses.gained, responses.band_gained.mean(axis=1)
    chosen = responses.row_of(claim.values[0])
    found = _leads(gained, responses.error, pd.Series(chosen, gained.columns))
    bands = "; ".join(
        f"{point}: {gained.index[row]}, {mean[row, number]:.2f} dB"
        for number, (point, row) in enumerate(zip(gained, mean.argmax(axis=0), strict=True))
    )
    return found._replace(evidence=f"{found.evidence}. In the mean over third octaves {bands}")


def nearest_patch(claim: Claim, responses: Responses) -> Finding:
    """Test whether at every point the nearest damper gives the largest reduction."""
    return _leads(responses.gained, responses.error, responses.distance.idxmin())


def nearest_point(claim: Claim, responses: Responses) -> Finding:
    """Test whether every damper reduces the point nearest to it more than the other points."""
    return _leads(responses.gained.T, responses.error.T, responses.distance.T.idxmin())


def _leads(gained: pd.DataFrame, error: pd.DataFrame, chosen: pd.Series[str]) -> Finding:
    """Test whether the chosen row of each column has the largest reduction."""
    margins, errors, parts = [], [], []
    for column in gained:
        gains, row = gained[column], chosen[column]
        rival = gains.drop(row).idxmax()
        margins.append(float(gains[row] - gains[rival]))
        errors.append(_pair_error(error[column], row, rival))
        first, second = (row, rival) if margins[-1] > 0 else (rival, row)
        ahead = f"{value_text(abs(margins[-1]), errors[-1])} dB more than {second}"
        parts.append(f"{column}: {first}, {gains[first]:.2f} dB, {ahead}")
    return _finding(margins, errors, "; ".join(parts))


def _pair_error(error: pd.Series[float], first: object, second: object) -> float:
    """Return the standard error of the difference of two levels, taken as independent."""
    return math.hypot(error[first], error[second])


def lowered(claim: Claim, responses: Responses) -> Finding:
    """Test whether every scenario lowers every point."""
    gained = responses.gained.to_numpy()
    count, ends = int((gained > 0).sum()), f"{gained.min():.2f} to {gained.max():.2f} dB"
    evidence = f"{count} of {gained.size} lowered, by {ends}"
    return _finding(gained, responses.error, evidence)


def alike(claim: Claim, responses: Responses) -> Finding:
    """Test whether the reductions are alike at every point."""
    gained, error = responses.gained, responses.error
    spread = gained.max() - gained.min()
    errors = [_pair_error(error[p], gained[p].idxmax(), gained[p].idxmin()) for p in gained]
    parts = [f"{p}: {value_text(spread[p], e)} dB" for p, e in zip(gained, errors, strict=True)]
    text = f"spread {'; '.join(parts)} (the same below {claim.alike_db:g} dB)"
    return _finding(claim.alike_db - spread, errors, text)


def high_frequency(claim: Claim, responses: Responses) -> Finding:
    """Test whether the reduction is larger in the upper half of the bands than in the lower.

    Errors are common to the bands of a half.
    """
    (centre, _), gained, error = responses.bands(), responses.band_gained, responses.band_error
    half = len(centre) // 2
    lower, upper = gained[:, :half].mean(axis=1), gained[:, half:].mean(axis=1)
    spread = np.hypot(error[:, :half].mean(axis=1), error[:, half:].mean(axis=1))
    return _finding(
        upper - lower,
        spread,
        f"in {int((upper > lower).sum())} of {lower.size} responses; mean over the third "
        f"octaves from {centre[half]:.0f} Hz {upper.mean():.2f} dB, below {lower.mean():.2f} dB",
    )


def linear(claim: Claim, responses: Responses) -> Finding:
    """Test whether each third octave rises by as many dB as the sound."""
    bands, bare = responses.bands()[1], responses.bands(is_bare=True)[1]
    return _rises(claim, responses, bands, bare, responses.band_error)


def linear_stretched(claim: Claim, responses: Responses) -> Finding:
    """Test whether motions rise by as many dB as the sound when the panel stretches."""
    motions, bare = responses.motions(), responses.motions(is_bare=True)
    error = np.broadcast_to(responses.error.to_numpy(float)[:, None], motions.shape)
    return _rises(claim, responses, motions, bare, error)


def _rises(claim: Claim, responses: Responses, rms: Array, bare: Array, error: Array) -> Finding:
    oaspl = [float(s.oaspl_db or np.nan) for s in responses.scenarios.values()]
    step = np.diff(oaspl)[:, None, None]
    rise, bare_rise = (np.diff(20 * np.log10(values), axis=0) for values in (rms, bare))
    parts = [
        f"{low:g} to {high:g} dB: {part.min():.2f} to {part.max():.2f} dB, "
        f"the bare panel {plain.min():.2f} to {plain.max():.2f} dB"
        for low, high, part, plain in zip(oaspl, oaspl[1:], rise, bare_rise, strict=False)
    ]
    text = f"rise from {'; from '.join(parts)} (linear within {claim.alike_db:g} dB)"
    margin = claim.alike_db - np.abs(rise - step)
    return _finding(margin, np.hypot(error[1:], error[:-1]), text)


COMPARISONS: Mapping[str, Callable[[Claim, Responses], Finding]] = {
    compare.__name__: compare
    for compare in (
        most_effective, lowered, alike, high_frequency,
        nearest_patch, nearest_point, linear, linear_stretched,
    )
}  # fmt: skip


def verdicts(
    study: Study, summary: pd.DataFrame, psd: xr.Dataset, distance: pd.DataFrame
) -> Iterator[Verdict]:
    """Test every claim of a study with each damping model."""
    points = moving_points(summary, list(study.panel.points))
    for claim, reading in itertools.product(study.claims, study.readings if points else ()):
        varied = study.families[claim.scenarios].varied
        scenarios = {
            WORDS[varied].format(getattr(scenario, varied)): scenario
            for scenario in study.family_scenarios(claim.scenarios)
            if claim.takes(getattr(scenario, varied))
        }
        patches = [patch for patch in distance.index if patch in scenarios]
        away = distance.loc[patches, points]
        responses = Responses(summary, psd, reading, points, scenarios, away)
        is_steady = bool(np.isfinite(responses.gained.to_numpy(float)).all())
        is_compared = len(points) > 1 or claim.comparison != "nearest_point"
        test = COMPARISONS[claim.comparison]
        yield Verdict(claim, reading, test(claim, responses) if is_steady and is_compared else None)


def patch_distance(basis: PanelBasis) -> pd.DataFrame:
    """Return distances [m] between patch centres (index) and points (columns)."""
    corners = basis.vertex_position[basis.cells]
    weight = basis.cell_in_patch * cell_areas(basis.vertex_position, basis.cells)
    centre = weight @ corners.mean(axis=1) / weight.sum(axis=1, keepdims=True)
    distance = np.linalg.norm(centre[:, None] - basis.point_position, axis=-1)
    return pd.DataFrame(distance, basis.patch_names, basis.point_names)


def verdict_table(verdicts: Sequence[Verdict]) -> Fragment | None:
    """Return the claims with the verdicts of all damping models; None without claims."""
    rows = [{**v._asdict(), "is_first": v.reading == verdicts[0].reading} for v in verdicts]
    return Fragment("claims.html", {"rows": rows, "significance": SIGNIFICANCE}) if rows else None
