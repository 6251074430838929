"""The paper's claims tested against the numbers of a study.

Each claim is a function of arrays that returns a `Finding`: whether it holds, and the evidence.
A claim is decided only where the numbers are further apart than `SIGNIFICANCE` of their standard
errors, and not at all where no errors are known. `verdicts` tests every claim that a study's
scenarios allow, for each damping model; `verdict_table` shows the verdicts.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Flags
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.panel.basis import PanelBasis
from pidpanel.report.answer import SIGNIFICANCE
from pidpanel.report.html import Fragment
from pidpanel.report.names import Study, family_of
from pidpanel.report.rms import band_error_of, band_rms_of, moving_points, rms_by
from pidpanel.report.text import percent, value_text
from pidpanel.solve.bands import reduction

# Difference [dB] below which two rms values are one to the reader of a plot of six decades.
ALIKE = 1.0

MOST_EFFECTIVE_FILL = 0.1  # fill fraction that the paper finds most effective (its section 3.1)

# Fill fractions between which the paper finds the responses almost the same.
ALIKE_FILLS = (0.7, 0.9)


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


def fill_is_most_effective(rms: pd.DataFrame, error: pd.DataFrame, gained: Array) -> Finding:
    """Test whether `MOST_EFFECTIVE_FILL` gives the lowest response at every point.

    The verdict follows the rms acceleration, which the lowest modes dominate; the evidence also
    names the best fill by the mean reduction over third octaves, with equal weight for all bands.
    ``gained``: (n_fills, n_bands, n_points) [dB].
    """
    margins, errors, parts = [], [], []
    for point in rms.columns:
        margin, spread, best, second = _lead(rms[point], error[point], MOST_EFFECTIVE_FILL)
        margins.append(margin)
        errors.append(spread)
        parts.append(f"point {point}: r = {best:g}, {_gap(margin, spread)} below r = {second:g}")
    mean = gained.mean(axis=1)
    by_band = "; ".join(
        f"point {point}: r = {rms.index[row]:g}, {mean[row, number]:.2f} dB"
        for number, (point, row) in enumerate(zip(rms.columns, mean.argmax(axis=0), strict=True))
    )
    text = f"lowest at {'; '.join(parts)}. In the mean over third octaves lowest at {by_band}"
    return _finding(margins, errors, text)


def _lead(
    levels: pd.Series[float], error: pd.Series[float], chosen: Any
) -> tuple[float, float, Any, Any]:
    """Return by how much [dB] a level is below the best other, the error, the lower, the higher."""
    rival = levels.drop(chosen).idxmin()
    margin = float(reduction(levels[rival], levels[chosen]))
    ends = (chosen, rival) if margin > 0 else (rival, chosen)
    return margin, _pair_error(error, chosen, rival), *ends


def _gap(decibel: float, error: float) -> str:
    return f"{value_text(abs(decibel), error)} dB"


def _pair_error(error: pd.Series[float], first: Any, second: Any) -> float:
    """Return the standard error of the difference of two levels, taken as independent."""
    return math.hypot(error[first], error[second])


def every_fill_lowers(rms: pd.DataFrame, error: pd.DataFrame, bare: pd.Series) -> Finding:
    """Test whether every fill lowers the response at every point."""
    gained = reduction(bare.reindex(rms.columns).to_numpy()[None], rms.to_numpy())
    lowered = int((gained > 0).sum())
    return _finding(
        gained,
        error.to_numpy(float),
        f"{lowered} of {gained.size} lowered, by {gained.min():.2f} to {gained.max():.2f} dB",
    )


def _between_fills(rms: pd.DataFrame) -> Flags:
    low, high = ALIKE_FILLS
    return np.asarray((rms.index >= low - 1e-9) & (rms.index <= high + 1e-9))


def fills_are_alike(rms: pd.DataFrame, error: pd.DataFrame) -> Finding:
    """Test whether the responses at `ALIKE_FILLS` lie within `ALIKE` of each other."""
    inside = _between_fills(rms)
    chosen, chosen_error = rms[inside], error[inside]
    spread = reduction(chosen.max().to_numpy(), chosen.min().to_numpy())
    errors = np.array(
        [_pair_error(chosen_error[p], chosen[p].idxmax(), chosen[p].idxmin()) for p in chosen]
    )
    parts = [
        f"point {p}: {_gap(s, e)}" for p, s, e in zip(rms.columns, spread, errors, strict=True)
    ]
    text = f"spread {'; '.join(parts)} (the same below {ALIKE:g} dB)"
    return _finding(ALIKE - spread, errors, text)


def more_at_high_frequency(gained: Array, error: Array, centre: Array) -> Finding:
    """Test whether the reduction is larger in the upper half of the bands than in the lower.

    Arrays: (n_scenarios, n_bands, n_points) [dB]; errors are common to the bands of a half.
    """
    half = len(centre) // 2
    lower, upper = gained[:, :half].mean(axis=1), gained[:, half:].mean(axis=1)
    spread = np.hypot(error[:, :half].mean(axis=1), error[:, half:].mean(axis=1))
    return _finding(
        upper - lower,
        spread,
        f"in {int((upper > lower).sum())} of {lower.size} responses; mean over the third "
        f"octaves from {centre[half]:.0f} Hz {upper.mean():.2f} dB, below {lower.mean():.2f} dB",
    )


def nearest_damper_is_best(
    rms: pd.DataFrame, error: pd.DataFrame, distance: pd.DataFrame
) -> Finding:
    """Test whether at every point the nearest damper gives the lowest response."""
    margins, errors, parts = [], [], []
    for point in rms.columns:
        nearest = distance[point].idxmin()
        margin, spread, best, second = _lead(rms[point], error[point], nearest)
        margins.append(margin)
        errors.append(spread)
        lead = _gap(margin, spread)
        parts.append(f"point {point}: {best}, {lead} below {second}; nearest {nearest}")
    return _finding(margins, errors, "lowest with " + "; ".join(parts))


def own_point_gains_most(
    gained: pd.DataFrame, error: pd.DataFrame, distance: pd.DataFrame
) -> Finding:
    """Test whether every damper lowers the point nearest to it more than the other points."""
    margins, errors, parts = [], [], []
    for patch in gained.index:
        gains, spread = gained.T[patch], error.T[patch]
        nearest: Any = distance.T[patch].idxmin()
        rival: Any = gains.drop(nearest).idxmax()
        margins.append(float(gains[nearest] - gains[rival]))
        errors.append(_pair_error(spread, nearest, rival))
        parts.append(
            f"{patch}: {value_text(gains[nearest], spread[nearest])} dB at the nearest "
            f"point, {nearest}, {value_text(gains[rival], spread[rival])} dB at {rival}"
        )
    return _finding(margins, errors, "; ".join(parts))


def shifts_with_level(rms: Array, error: Array, oaspl: Array) -> Finding:
    """Test whether each band's response rises by as many dB as the sound.

    Arrays: (n_levels, n_bands, n_points), errors in dB.
    """
    order = np.argsort(oaspl)
    rise = np.diff(20 * np.log10(rms[order]), axis=0)
    step = np.diff(oaspl[order])[:, None, None]
    spread = np.hypot(error[order][1:], error[order][:-1])
    return _finding(
        ALIKE - np.abs(rise - step),
        spread,
        f"steps of {step.min():g} dB in the sound raise the third octaves by {rise.min():.2f} "
        f"to {rise.max():.2f} dB (linear within {ALIKE:g} dB)",
    )


def shifts_when_stretched(rms: Array, bare: Array, error: Array, oaspl: Array) -> Finding:
    """Test whether motions rise by as many dB as the sound when the panel stretches.

    ``rms``, of a scenario, and its ``error`` [dB], and ``bare``: (n_levels, n_motions, n_points).
    """
    order = np.argsort(oaspl)
    step = np.diff(oaspl[order])[:, None, None]
    rise, bare_rise = (np.diff(20 * np.log10(values[order]), axis=0) for values in (rms, bare))
    spread = np.hypot(error[order][1:], error[order][:-1])
    parts = [
        f"{low:g} to {high:g} dB: {part.min():.2f} to {part.max():.2f} dB, "
        f"the bare panel {plain.min():.2f} to {plain.max():.2f} dB"
        for low, high, part, plain in zip(
            oaspl[order][:-1], oaspl[order][1:], rise, bare_rise, strict=True
        )
    ]
    text = f"g rms and displacement rise from {'; from '.join(parts)} (linear within {ALIKE:g} dB)"
    return _finding(ALIKE - np.abs(rise - step), spread, text)


def _stretched(summary: pd.DataFrame, labels: Mapping[object, str], points: Sequence[str]) -> Array:
    """Return g rms and displacement with stretching (n_levels, 2, n_points), linear without."""
    motions = []
    for name in ("acceleration_rms_g", "displacement_rms_mm"):
        linear = rms_by(summary, labels, points, name)
        stretched = rms_by(summary, labels, points, f"stretched_{name}")
        motions.append(stretched.fillna(linear).to_numpy(float))
    return np.stack(motions, axis=1)


def verdicts(
    study: Study, summary: pd.DataFrame, psd: xr.Dataset, distance: pd.DataFrame
) -> Iterator[Verdict]:
    """Test every claim of the paper that the study's scenarios allow, for each damping model."""
    points = moving_points(summary, list(study.panel.points))
    families = [family_of(study, name) for name in study.families if points]
    groups = [(family.varied, *group) for family in families for group in family.groups.items()]
    for varied, model, scenarios in groups:
        if varied == "damper":
            continue
        labels: dict[object, str] = {getattr(s, varied): s.label for s in scenarios}
        rms = rms_by(summary, labels, points)
        error = rms_by(summary, labels, points, "reduction_error_db")
        bare_labels = [s.bare.label for s in scenarios]
        bare = rms_by(summary, {label: label for label in bare_labels}, points)
        centre, band = band_rms_of(psd, list(labels.values()), points)
        spread = band_error_of(psd, list(labels.values()), points)
        tests: dict[str, Callable[[], Finding]] = {}
        if varied == "fill_fraction":
            _, bare_band = band_rms_of(psd, bare_labels, points)
            gained = reduction(bare_band, band)
            if MOST_EFFECTIVE_FILL in rms.index and len(rms) > 1:
                claim = f"A fill of {percent(MOST_EFFECTIVE_FILL)} is the most effective"
                tests[f"{claim} at all points"] = partial(
                    fill_is_most_effective, rms, error, gained
                )
            claim = "Every fill lowers the response at every point"
            tests[claim] = partial(every_fill_lowers, rms, error, bare.iloc[0])
            claim = "The effect is larger at high frequency"
            tests[claim] = partial(more_at_high_frequency, gained, spread, centre)
            low, high = ALIKE_FILLS
            if _between_fills(rms).sum() > 1:
                claim = f"Fills of {percent(low)} to {percent(high)} give almost the same response"
                tests[claim] = partial(fills_are_alike, rms, error)
        elif varied == "patch":
            away = distance.loc[list(rms.index), list(rms.columns)]
            if len(rms) > 1:
                claim = "At each point the nearest damper gives the lowest response"
                tests[claim] = partial(nearest_damper_is_best, rms, error, away)
            if len(rms.columns) > 1:
                gains = reduction(bare.to_numpy(float), rms.to_numpy(float))
                by_patch = pd.DataFrame(gains, rms.index, rms.columns)
                claim = "Each damper reduces the response most at the point nearest to it"
                tests[claim] = partial(own_point_gains_most, by_patch, error, away)
        elif len(rms) > 1:
            oaspl = np.array([s.oaspl_db for s in scenarios], float)
            claim = "The response shifts linearly with the sound level"
            tests[claim] = partial(shifts_with_level, band, spread, oaspl)
            stretched = rms_by(summary, labels, points, "stretched_acceleration_rms_g")
            if stretched.notna().to_numpy().any():
                bare_by_level = dict(zip(labels, bare_labels, strict=True))
                motion, plain = (
                    _stretched(summary, names, points) for names in (labels, bare_by_level)
                )
                errors = np.repeat(error.to_numpy(float)[:, None], motion.shape[1], axis=1)
                claim = f"{claim}, with the stretching of the panel"
                tests[claim] = partial(shifts_when_stretched, motion, plain, errors, oaspl)
        is_steady = bool(np.isfinite(rms.to_numpy(float)).all())
        for claim, test in tests.items():
            yield Verdict(claim, model, test() if is_steady else None)


def patch_distance(basis: PanelBasis) -> pd.DataFrame:
    """Return distances [m] between patch centres (index) and points (columns)."""
    corners = basis.vertex_position[basis.cells]
    weight = basis.cell_in_patch * cell_areas(basis.vertex_position, basis.cells)
    centre = weight @ corners.mean(axis=1) / weight.sum(axis=1, keepdims=True)
    distance = np.linalg.norm(centre[:, None] - basis.point_position, axis=-1)
    return pd.DataFrame(distance, basis.patch_names, basis.point_names)


class Finding(NamedTuple):
    """Whether a claim holds, and the numbers behind it."""

    holds: bool | None  # None where the numbers do not decide
    evidence: str  # the numbers in words
    has_errors: bool = True  # whether the numbers have errors


class Verdict(NamedTuple):
    """The finding on a claim for one damping model."""

    claim: str
    model: str
    finding: Finding | None  # None without a steady response


def verdict_table(verdicts: Sequence[Verdict]) -> Fragment | None:
    """Return the claims with the verdicts of all damping models; None without claims."""
    if not verdicts:
        return None
    by_claim: dict[str, list[Verdict]] = {}
    for verdict in verdicts:
        by_claim.setdefault(verdict.claim, []).append(verdict)
    rows = [
        {**verdict._asdict(), "is_first": verdict is group[0]}
        for group in by_claim.values()
        for verdict in group
    ]
    return Fragment("claims.html", {"rows": rows, "significance": SIGNIFICANCE})
