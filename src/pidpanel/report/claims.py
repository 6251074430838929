"""The paper's claims tested against the numbers of a study.

Each claim is a function of arrays that returns a `Finding`: whether it holds, and the evidence.
`verdicts` tests every claim that a study's scenarios allow, in each reading of the damping;
`verdict_table` shows the verdicts.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.panel.basis import PanelBasis
from pidpanel.plane_mesh import cell_areas
from pidpanel.report.html import Table
from pidpanel.report.rms import band_rms_of, moving_points, rms_by
from pidpanel.report.text import READINGS, percent
from pidpanel.response.bands import reduction
from pidpanel.study import Study

ALIKE = 1.0
"""Difference [dB] below which two rms values are one to the reader of a plot of six decades."""

MOST_EFFECTIVE_FILL = 0.1
"""Fill fraction that the paper finds most effective (its section 3.1)."""

ALIKE_FILLS = (0.7, 0.9)
"""Fill fractions between which the paper finds the responses almost the same."""


@dataclass(frozen=True)
class Finding:
    """Whether a claim holds, and the numbers behind it.

    Attributes
    ----------
    holds
        The verdict.
    evidence
        The numbers in words.
    """

    holds: bool
    evidence: str


@dataclass(frozen=True)
class Verdict:
    """The finding on a claim in one reading.

    Attributes
    ----------
    claim
        The claim in words.
    reading
        Reading of the damping, such as ``dem``.
    finding
        None where the claim cannot be tested.
    reason
        Why it cannot be tested.
    """

    claim: str
    reading: str
    finding: Finding | None
    reason: str = ""


def fill_is_most_effective(rms: pd.DataFrame, fill: float, gained: Array) -> Finding:
    """Test whether one fill gives the lowest response at every point.

    The verdict follows the rms acceleration, which the lowest modes dominate; the evidence also
    names the best fill by the mean reduction over third octaves, in which all bands count alike.

    Parameters
    ----------
    rms
        Rms acceleration in any unit; index fill fraction, columns points.
    fill
        The fill tested, one of the index.
    gained
        Reduction of the bands' rms [dB], shape ``(n_fills, n_bands, n_points)``, in the order
        of ``rms``.
    """
    parts = []
    for point in rms.columns:
        of = rms[point]
        best = float(of.index[int(of.argmin())])
        if best == fill:
            margin = float(reduction(of[of.index != fill].min(), of.min()))
            parts.append(f"point {point}: r = {best:g}, by {_small(margin)} dB")
        else:
            margin = float(reduction(of[of.index == fill].min(), of.min()))
            parts.append(f"point {point}: r = {best:g}, {_small(margin)} dB below r = {fill:g}")
    mean = gained.mean(axis=1)
    by_band = "; ".join(
        f"point {point}: r = {rms.index[best]:g}, {mean[best, number]:.2f} dB"
        for number, (point, best) in enumerate(zip(rms.columns, mean.argmax(axis=0), strict=True))
    )
    return Finding(
        bool((rms.idxmin() == fill).all()),
        f"lowest at {'; '.join(parts)}. By the mean over third octaves best at {by_band}",
    )


def _small(decibel: float) -> str:
    """Return a difference to two decimals, or that it is smaller than that."""
    return f"{decibel:.2f}" if decibel >= 0.01 else "less than 0.01"


def every_fill_lowers(rms: pd.DataFrame, bare: pd.Series) -> Finding:
    """Test whether every fill lowers the response at every point.

    Parameters
    ----------
    rms
        Rms acceleration; index fill fraction, columns points.
    bare
        Rms acceleration of the bare panel, by point.
    """
    gained = reduction(bare.reindex(rms.columns).to_numpy()[None], rms.to_numpy())
    lowered = int((gained > 0).sum())
    return Finding(
        lowered == gained.size,
        f"{lowered} of {gained.size} lowered, by {gained.min():.2f} to {gained.max():.2f} dB",
    )


def fills_are_alike(rms: pd.DataFrame, fills: tuple[float, float] = ALIKE_FILLS) -> Finding:
    """Test whether the responses within a range of fills lie within `ALIKE` of each other.

    Parameters
    ----------
    rms
        Rms acceleration; index fill fraction, columns points; at least two within ``fills``.
    fills
        The range, both ends included.
    """
    low, high = fills
    chosen = rms[(rms.index >= low - 1e-9) & (rms.index <= high + 1e-9)]
    spread = reduction(chosen.max().to_numpy(), chosen.min().to_numpy())
    return Finding(
        bool((spread < ALIKE).all()),
        "spread "
        + "; ".join(f"point {p}: {s:.2f} dB" for p, s in zip(rms.columns, spread, strict=True))
        + f" (alike below {ALIKE:g} dB)",
    )


def more_at_high_frequency(gained: Array, centre: Array) -> Finding:
    """Test whether the reduction is larger in the upper half of the bands than in the lower.

    Parameters
    ----------
    gained
        Reduction of the bands' rms [dB], shape ``(n_scenarios, n_bands, n_points)``.
    centre
        Rising centres of the bands [Hz], shape ``(n_bands,)``.
    """
    half = len(centre) // 2
    below = gained[:, :half].mean(axis=1)
    above = gained[:, half:].mean(axis=1)
    count = int((above > below).sum())
    return Finding(
        count == below.size,
        f"in {count} of {below.size} responses; mean over the third octaves from "
        f"{centre[half]:.0f} Hz {above.mean():.2f} dB, below {below.mean():.2f} dB",
    )


def nearest_damper_is_best(rms: pd.DataFrame, distance: pd.DataFrame) -> Finding:
    """Test whether at every point the nearest damper gives the lowest response.

    Parameters
    ----------
    rms
        Rms acceleration; index patch, columns points.
    distance
        Distance of the patch's centre from the point [m]; same index and columns.
    """
    parts, count = [], 0
    for point in rms.columns:
        nearest, best = distance[point].idxmin(), rms[point].idxmin()
        count += nearest == best
        margin = float(reduction(rms[point].drop(best).min(), rms[point].min()))
        parts.append(f"point {point}: {best} by {_small(margin)} dB, nearest {nearest}")
    return Finding(count == len(rms.columns), "lowest with " + "; ".join(parts))


def own_point_gains_most(gained: pd.DataFrame, distance: pd.DataFrame) -> Finding:
    """Test whether every damper lowers the point nearest to it more than the other points.

    Parameters
    ----------
    gained
        Reduction [dB]; index patch, columns points.
    distance
        Distance of the patch's centre from the point [m]; same index and columns.
    """
    parts, count = [], 0
    for patch in gained.index:
        of = gained.T[patch]
        nearest, best = distance.T[patch].idxmin(), of.idxmax()
        count += nearest == best
        parts.append(
            f"{patch}: {of.max():.2f} dB at point {best}, {of[nearest]:.2f} dB at the nearest, "
            f"{nearest}"
        )
    return Finding(count == len(gained.index), "; ".join(parts))


def shifts_with_level(rms: Array, oaspl: Array) -> Finding:
    """Test whether each band's response rises by as many dB as the sound.

    Parameters
    ----------
    rms
        Rms acceleration in any unit, shape ``(n_levels, n_bands, n_points)``.
    oaspl
        Overall levels of the sound [dB], shape ``(n_levels,)``.
    """
    order = np.argsort(oaspl)
    rise = np.diff(20 * np.log10(rms[order]), axis=0)
    step = np.diff(oaspl[order])[:, None, None]
    off = np.abs(rise - step).max()
    return Finding(
        bool(off < ALIKE),
        f"steps of {step.min():g} dB in the sound raise the third octaves by {rise.min():.2f} to "
        f"{rise.max():.2f} dB (linear within {ALIKE:g} dB)",
    )


def verdicts(
    study: Study, summary: pd.DataFrame, psd: xr.Dataset, distance: pd.DataFrame
) -> list[Verdict]:
    """Test every claim of the paper that the study's scenarios allow, in each reading.

    Parameters
    ----------
    study
        The study.
    summary, psd
        ``response/summary.csv`` (points as text) and ``response/psd.nc``.
    distance
        From `patch_distance`.
    """
    return [
        verdict
        for name in study.families
        for reading in study.readings
        for verdict in _family_verdicts(study, name, reading, summary, psd, distance)
    ]


def _family_verdicts(
    study: Study,
    name: str,
    reading: str,
    summary: pd.DataFrame,
    psd: xr.Dataset,
    distance: pd.DataFrame,
) -> Iterator[Verdict]:
    scenarios = study.family_scenarios(name)
    points = moving_points(summary, list(study.panel.points))
    if not points:
        return
    varied = study.families[name].varied
    labels: dict[object, str] = {getattr(s, varied): s.label for s in scenarios}
    rms = rms_by(summary, reading, labels, points)
    bare_labels = [s.bare.label for s in scenarios]
    bare = rms_by(summary, reading, {label: label for label in bare_labels}, points)
    whole = bool(np.isfinite(rms.to_numpy(float)).all())

    def verdict(claim: str, find: Finding | None) -> Verdict:
        return Verdict(claim, reading, find, "" if find else "no steady response")

    centre, band = band_rms_of(psd, reading, list(labels.values()), points)
    if varied == "fill_fraction":
        _, bare_band = band_rms_of(psd, reading, bare_labels, points)
        if MOST_EFFECTIVE_FILL in rms.index:
            yield verdict(
                f"A fill of {percent(MOST_EFFECTIVE_FILL)} is the most effective at all points",
                fill_is_most_effective(rms, MOST_EFFECTIVE_FILL, reduction(bare_band, band))
                if whole
                else None,
            )
        yield verdict(
            "Every fill lowers the response at every point",
            every_fill_lowers(rms, bare.iloc[0]) if whole else None,
        )
        yield verdict(
            "The effect is larger at high frequency",
            more_at_high_frequency(reduction(bare_band, band), centre) if whole else None,
        )
        low, high = ALIKE_FILLS
        if ((rms.index >= low - 1e-9) & (rms.index <= high + 1e-9)).sum() > 1:
            yield verdict(
                f"Fills of {percent(low)} to {percent(high)} give almost the same response",
                fills_are_alike(rms) if whole else None,
            )
    elif varied == "patch":
        away = distance.loc[list(rms.index), points]
        gained = pd.DataFrame(
            reduction(bare.to_numpy(float), rms.to_numpy(float)), rms.index, rms.columns
        )
        yield verdict(
            "At each point the nearest damper gives the lowest response",
            nearest_damper_is_best(rms, away) if whole else None,
        )
        yield verdict(
            "Each damper reduces the response most at the point nearest to it",
            own_point_gains_most(gained, away) if whole else None,
        )
    else:
        oaspl = np.array([s.oaspl_db for s in scenarios], float)
        yield verdict(
            "The response shifts linearly with the sound level",
            shifts_with_level(band, oaspl) if whole else None,
        )


def patch_distance(basis: PanelBasis) -> pd.DataFrame:
    """Return distances [m] between patch centres (index) and points (columns)."""
    corners = basis.vertex_position[basis.cells]
    weight = basis.cell_in_patch * cell_areas(basis.vertex_position, basis.cells)
    centre = weight @ corners.mean(axis=1) / weight.sum(axis=1, keepdims=True)
    away = np.linalg.norm(centre[:, None] - basis.point_position, axis=-1)
    return pd.DataFrame(away, basis.patch_names, basis.point_names)


def verdict_table(verdicts: Sequence[Verdict]) -> Table | None:
    """Return the claims, each once with all its readings, and the verdicts; None for none."""
    if not verdicts:
        return None
    rows = []
    for verdict in verdicts:
        if verdict.finding is None:
            answer, evidence = "cannot be tested", verdict.reason
        else:
            answer = "holds" if verdict.finding.holds else "does not hold"
            evidence = verdict.finding.evidence
        rows.append([verdict.claim, READINGS[verdict.reading], answer, evidence])
    claims = list(dict.fromkeys(verdict.claim for verdict in verdicts))
    rows.sort(key=lambda row: claims.index(row[0]))
    for before, row in reversed(list(pairwise(rows))):
        row[0] = "" if row[0] == before[0] else row[0]
    return Table(
        "The paper's claims tested against these results",
        ["claim", "reading", "verdict", "evidence (rms acceleration)"],
        rows,
    )
