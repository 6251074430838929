"""The paper's claims put to the numbers, and where the numbers must not be trusted.

Each claim is a function of arrays that answers with a verdict and its evidence; nothing is
decided beforehand. `verdicts` puts them to every reading of the damping in a study.

Tolerances are what a reader of a PSD plot would call alike: `ALIKE` dB.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.panel.modes import PanelBasis
from pidpanel.plane_mesh import cell_areas
from pidpanel.response.bands import band_rms, reduction, third_octaves
from pidpanel.study import Study

ALIKE = 1.0
"""dB; two rms values closer than this are one to whoever reads a plot over six decades."""

MOST_EFFECTIVE_FILL = 0.1
"""Fill fraction that the paper finds most effective (its section 3.1)."""

ALIKE_FILLS = (0.7, 0.9)
"""Fill fractions between which the paper finds the responses almost the same."""


POWER_BALANCE = 1e-3
"""Share of the power put in that may be unaccounted for: beyond it the response is in doubt by
more than its PSD can be read."""


@dataclass(frozen=True)
class Finding:
    """Whether a claim holds, and the numbers that say so."""

    holds: bool
    evidence: str


@dataclass(frozen=True)
class Verdict:
    """A `Finding` under the claim's own words; ``finding`` is None where none can be made."""

    claim: str
    reading: str
    finding: Finding | None
    reason: str = ""


# --------------------------------------------------------------------------- the claims


def fill_is_most_effective(rms: pd.DataFrame, fill: float, gained: Array) -> Finding:
    """Does one fill give the lowest response at every point?

    The verdict goes by the rms acceleration, which the lowest modes rule; the evidence also
    names the best fill by the mean reduction over third octaves, in which all bands count alike.

    Parameters
    ----------
    rms
        Rms acceleration, any unit; index fill fraction, columns points.
    fill
        The fill in question, one of the index.
    gained
        (fills, bands, points) reduction of the band's rms, dB, in the order of ``rms``.
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
    """A difference to two decimals, or that it is smaller than they show."""
    return f"{decibel:.2f}" if decibel >= 0.01 else "less than 0.01"


def every_fill_lowers(rms: pd.DataFrame, bare: pd.Series) -> Finding:
    """Does every fill lower the response at every point?

    Parameters
    ----------
    rms
        Rms acceleration; index fill fraction, columns points.
    bare
        That of the bare panel, by point.
    """
    gained = reduction(bare.reindex(rms.columns).to_numpy()[None], rms.to_numpy())
    lowered = int((gained > 0).sum())
    return Finding(
        lowered == gained.size,
        f"{lowered} of {gained.size} lowered, by {gained.min():.2f} to {gained.max():.2f} dB",
    )


def fills_are_alike(rms: pd.DataFrame, fills: tuple[float, float] = ALIKE_FILLS) -> Finding:
    """Do the responses within a range of fills lie within `ALIKE` of each other?

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
    """Is the reduction larger in the upper half of the bands than in the lower?

    Parameters
    ----------
    gained
        (scenarios, bands, points) reduction of the band's rms, dB.
    centre
        (bands,) rising, Hz.
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
    """At every point, does the nearest of the dampers give the lowest response?

    Parameters
    ----------
    rms
        Rms acceleration; index patch, columns points.
    distance
        From the patch's centre to the point, m; same index and columns.
    """
    parts, count = [], 0
    for point in rms.columns:
        nearest, best = distance[point].idxmin(), rms[point].idxmin()
        count += nearest == best
        margin = float(reduction(rms[point].drop(best).min(), rms[point].min()))
        parts.append(f"point {point}: {best} by {_small(margin)} dB, nearest {nearest}")
    return Finding(count == len(rms.columns), "lowest with " + "; ".join(parts))


def own_point_gains_most(gained: pd.DataFrame, distance: pd.DataFrame) -> Finding:
    """Does every damper lower the point nearest to it more than the other points?

    Parameters
    ----------
    gained
        Reduction, dB; index patch, columns points.
    distance
        From the patch's centre to the point, m; same index and columns.
    """
    parts, count = [], 0
    for patch in gained.index:
        of = gained.T[patch]
        nearest, best = distance.T[patch].idxmin(), of.idxmax()
        count += nearest == best
        parts.append(
            f"{patch}: {of.max():.2f} dB at {best}, {of[nearest]:.2f} dB at {nearest} nearest to it"
        )
    return Finding(count == len(gained.index), "; ".join(parts))


def shifts_with_level(rms: Array, oaspl: Array) -> Finding:
    """Does each band's response rise by as many dB as the sound?

    Parameters
    ----------
    rms
        (levels, bands, points) rms acceleration.
    oaspl
        (levels,) dB.
    """
    order = np.argsort(oaspl)
    rise = np.diff(20 * np.log10(rms[order]), axis=0)
    step = np.diff(oaspl[order])[:, None, None]
    off = np.abs(rise - step).max()
    return Finding(
        bool(off < ALIKE),
        f"steps of {step.min():g} dB in sound give {rise.min():.2f} to {rise.max():.2f} dB "
        f"in the third octaves (linear within {ALIKE:g} dB)",
    )


# --------------------------------------------------------------------------- a study's verdicts


def rms_by(
    summary: pd.DataFrame, reading: str, labels: Mapping[object, str], points: Sequence[str]
) -> pd.DataFrame:
    """Rms acceleration, g, of scenarios by what they are known as; NaN where there is none.

    Parameters
    ----------
    summary
        ``response/summary.csv``.
    reading
        One of its readings.
    labels
        Labels of the scenarios by the index wanted.
    points
        The columns wanted.
    """
    of = summary[summary["reading"] == reading]
    wide = of.pivot(index="scenario", columns="point", values="acceleration_rms_g")
    frame = wide.reindex(index=list(labels.values()), columns=list(points))
    return frame.set_axis(pd.Index(list(labels)), axis=0)


def scenario_band_rms(
    psd: xr.Dataset, reading: str, labels: Sequence[str], points: Sequence[str]
) -> tuple[Array, Array]:
    """Third-octave rms acceleration of scenarios.

    Returns
    -------
    centre
        (bands,) Hz.
    rms
        (scenarios, bands, points) m/s².
    """
    frequency = psd["frequency"].to_numpy()
    chosen = psd["acceleration_psd"].sel(reading=reading, scenario=list(labels), point=list(points))
    values = chosen.transpose("frequency", "scenario", "point").to_numpy()
    centre, edge = third_octaves(frequency[0], frequency[-1])
    return centre, band_rms(frequency, values, edge).transpose(1, 0, 2)


def verdicts(
    study: Study, summary: pd.DataFrame, psd: xr.Dataset, distance: pd.DataFrame
) -> list[Verdict]:
    """Every claim of the paper that the study's scenarios can put to a test, in each reading.

    Parameters
    ----------
    study
        The study.
    summary, psd
        ``response/summary.csv`` (points as text) and ``response/psd.nc``.
    distance
        Of patches and points, see `patch_distance`.
    """
    return [
        verdict
        for name in study.scenarios
        for reading in study.damping.readings
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
    points = list(study.panel.points)
    varied = study.scenarios[name].varied
    labels: dict[object, str] = {getattr(s, varied): s.label for s in scenarios}
    rms = rms_by(summary, reading, labels, points)
    bare_labels = [s.bare.label for s in scenarios]
    bare = rms_by(summary, reading, {label: label for label in bare_labels}, points)
    whole = bool(np.isfinite(rms.to_numpy(float)).all())

    def verdict(claim: str, find: Finding | None) -> Verdict:
        return Verdict(claim, reading, find, "" if find else "no steady response")

    centre, band = scenario_band_rms(psd, reading, list(labels.values()), points)
    if varied == "fill_fraction":
        _, bare_band = scenario_band_rms(psd, reading, bare_labels, points)
        if MOST_EFFECTIVE_FILL in rms.index:
            yield verdict(
                f"A fill of {MOST_EFFECTIVE_FILL:.0%} is the most effective at all points",
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
                f"Fills of {low:.0%} to {high:.0%} give almost the same response",
                fills_are_alike(rms) if whole else None,
            )
    elif varied == "patch":
        away = distance.loc[list(rms.index), points]
        gained = pd.DataFrame(
            reduction(bare.to_numpy(float), rms.to_numpy(float)), rms.index, rms.columns
        )
        yield verdict(
            "At each point the damper nearest to it gives the lowest response",
            nearest_damper_is_best(rms, away) if whole else None,
        )
        yield verdict(
            "Each damper lowers the point nearest to it most",
            own_point_gains_most(gained, away) if whole else None,
        )
    else:
        oaspl = np.array([s.oaspl_db for s in scenarios], float)
        yield verdict(
            "The response shifts linearly with the level of the sound",
            shifts_with_level(band, oaspl) if whole else None,
        )


def patch_distance(basis: PanelBasis) -> pd.DataFrame:
    """Distance of patch centres (index) and points (columns), m."""
    corners = basis.vertex_position[basis.cells]
    weight = basis.cell_in_patch * cell_areas(basis.vertex_position, basis.cells)
    centre = weight @ corners.mean(axis=1) / weight.sum(axis=1, keepdims=True)
    away = np.linalg.norm(centre[:, None] - basis.point_position, axis=-1)
    return pd.DataFrame(away, basis.patch_names, basis.point_names)


# --------------------------------------------------------------------------- in sentences


def outcome(study: Study, summary: pd.DataFrame, names: Mapping[str, str]) -> list[str]:
    """What came out, a sentence for each family and reading.

    Parameters
    ----------
    study
        The study.
    summary
        ``response/summary.csv`` with the points as text.
    names
        What each reading is called.
    """
    sentences = []
    points = list(study.panel.points)
    for reading, family in product(study.damping.readings, study.scenarios):
        scenarios = study.family_scenarios(family)
        varied = study.scenarios[family].varied
        labels: dict[object, str] = {getattr(s, varied): s.label for s in scenarios}
        bare_labels = {getattr(s, varied): s.bare.label for s in scenarios}
        rms = rms_by(summary, reading, labels, points)
        bare = rms_by(summary, reading, bare_labels, points)
        gained = pd.DataFrame(reduction(bare, rms), rms.index, rms.columns)
        if not np.isfinite(gained.to_numpy()).all():
            continue  # the warnings say so
        if varied == "oaspl_db":
            gained = gained.sort_index()
            low, high = gained.index[0], gained.index[-1]
            said = "the damper lowers the rms acceleration by " + ", ".join(
                f"{gained[p].iloc[0]:.1f} dB (sound at {low:g} dB) and {gained[p].iloc[-1]:.1f} dB "
                f"({high:g} dB) at point {p}"
                for p in points
            )
        else:
            what, name = ("fill", "r = ") if varied == "fill_fraction" else ("place", "")
            said = f"the best {what} is " + ", ".join(
                f"{name}{gained[p].idxmax()} at point {p} ({gained[p].max():.1f} dB below the bare "
                f"panel, {rms[p].min():.3g} g rms)"
                for p in points
            )
        sentences.append(f"{names[reading]}: {said}.")
    return sentences


def response_warnings(
    study: Study, summary: pd.DataFrame, psd: xr.Dataset, names: Mapping[str, str]
) -> list[str]:
    """Where the response is not to be trusted.

    Parameters
    ----------
    study
        The study.
    summary, psd
        ``response/summary.csv`` (points as text) and ``response/psd.nc``.
    names
        What each reading is called.
    """
    good = summary[summary["status"] == "ok"]
    warnings = []
    beyond = good[good["beyond_linear_plate"].astype(bool)]
    if len(beyond):
        worst = beyond.iloc[int(beyond["displacement_rms_mm"].argmax())]
        place = ["scenario", "point"]
        left, all_ = len(beyond.drop_duplicates(place)), len(good.drop_duplicates(place))
        warnings.append(
            f"Linear plate theory is left in {left} of {all_} scenarios and points: w rms exceeds "
            f"a tenth of the thickness ({study.panel.section.thickness_mm:g} mm); the largest is "
            f"{worst['displacement_rms_mm']:.3g} mm ({worst['scenario']}, point {worst['point']}). "
            "A real panel stiffens there by its membrane stress, which is left out here."
        )
    for reading in dict.fromkeys(good["reading"]):
        one = good[good["reading"] == reading].drop_duplicates("scenario")
        outside = one[one["outside_run_points_share"] > 0]
        if len(outside):
            parts = [
                f"{row['scenario']} {row['outside_run_points_share']:.0%} of the lines at "
                f"Γ = {row['damping_read_at_g']:.3g} ({_where(psd, reading, row['scenario'])})"
                for _, row in outside.iterrows()
            ]
            shares = np.concatenate(
                [_continued_share(study, psd, reading, label) for label in outside["scenario"]]
            )
            warnings.append(
                f"{names[reading]}: C_e is read outside the run points, so it continues what was "
                f"run: {'; '.join(parts)}. These lines make {shares.min():.0%} to "
                f"{shares.max():.0%} of the change in mean square against the bare panel."
            )
        several = one[one["levels"] > 1]
        if len(several):
            warnings.append(
                f"{names[reading]}: more than one level reproduces itself in "
                + ", ".join(several["scenario"])
                + "; the one with the largest motion is shown."
            )
    balance = good["power_balance_error"].max()
    if balance > POWER_BALANCE:
        warnings.append(
            f"Power put in and power lost differ by up to {balance:.1e} of the power put in."
        )
    unstable = summary[summary["status"] != "ok"].drop_duplicates(["reading", "scenario"])
    for reading, rows in unstable.groupby("reading", sort=False):
        warnings.append(
            f"{names[str(reading)]}: no steady response in {len(rows)} scenarios "
            f"({', '.join(rows['scenario'])}): {', '.join(dict.fromkeys(rows['status']))}."
        )
    return warnings


def _where(psd: xr.Dataset, reading: str, scenario: str) -> str:
    """The ranges of frequency in which a scenario's damping is a continuation."""
    inside = psd["inside"].sel(reading=reading, scenario=scenario).to_numpy() > 0.5
    frequency = psd["frequency"].to_numpy()
    edges = np.flatnonzero(np.diff(inside.astype(int))) + 1
    runs = np.split(np.arange(len(frequency)), edges)
    parts = [
        f"{frequency[run[0]]:.0f}–{frequency[run[-1]]:.0f} Hz" for run in runs if not inside[run[0]]
    ]
    return ", ".join(parts)


def _continued_share(study: Study, psd: xr.Dataset, reading: str, label: str) -> Array:
    """Share of the change of the mean square that comes from a continuation, by point.

    ∫|S_bare − S| df over the lines outside the run points, over that of all lines.
    """
    (bare,) = (s.bare.label for s in study.all_scenarios() if s.label == label)
    of = psd.sel(reading=reading).transpose(..., "frequency", "point")
    before, after = (of["acceleration_psd"].sel(scenario=s).to_numpy() for s in (bare, label))
    change = np.abs(before - after)
    outside = of["inside"].sel(scenario=label).to_numpy() < 0.5
    frequency = psd["frequency"].to_numpy()
    part = np.trapezoid(np.where(outside[:, None], change, 0.0), frequency, axis=0)
    whole = np.trapezoid(change, frequency, axis=0)
    share: Array = np.divide(part, whole, out=np.zeros_like(whole), where=whole > 0)
    return share


FEW_CASES = (
    "The cases of this study were chosen until the standard errors met damping.target. With few "
    "cases these errors are too small: on the paper's study rms accelerations stated to 5 % were "
    "1 to 18 % from those of the whole sweep (docs/theory.md, Target). Where a number decides, run "
    "the whole sweep."
)


def target_warnings(rounds: Sequence[Mapping[str, Any]]) -> list[str]:
    """What a target reached with few cases is worth, or that it was not reached.

    Parameters
    ----------
    rounds
        ``design/round*.json`` in order; empty for a study without a target.
    """
    if not rounds:
        return []
    last = rounds[-1]
    if last["reached"]:
        return [FEW_CASES]
    above = {
        label: max(of.values())
        for label, of in last["relative_error"].items()
        if max(of.values()) > last["target"]
    }
    return [
        f"damping.target is not reached: {len(last['cases'])} cases were run, none is left or "
        "allowed, and of the rms accelerations asked for within a standard error of "
        f"{last['target']:.2%} these are not: "
        + ", ".join(f"{label} {error:.2%}" for label, error in above.items())
        + "."
    ]


def coupon_warnings(cases: pd.DataFrame) -> list[str]:
    """Cases of the coupon that do not count or count less than asked.

    Parameters
    ----------
    cases
        ``coupon/cases.csv``.
    """
    warnings = []
    for status, rows in cases[cases["status"] != "ok"].groupby("status", sort=True):
        warnings.append(
            f"{len(rows)} of {len(cases)} coupon cases do not count ({status}): "
            + ", ".join(rows["case"])
            + "."
        )
    good = cases[cases["status"] == "ok"]
    missed = good[~good["target_met"].astype(bool)]
    if len(missed):
        relative = (
            missed["equivalent_damping_error_n_s_m3"] / missed["equivalent_damping_n_s_m3"]
        ).abs()
        warnings.append(
            f"{len(missed)} of {len(cases)} coupon cases ran to max_cycles without the accuracy "
            f"asked for; their relative standard errors reach {relative.max():.0%}."
        )
    above = good[good["share_of_bound"] > 1]
    if len(above):
        warnings.append(
            f"{len(above)} of {len(cases)} coupon cases exceed the bound of an inelastic bed (up "
            f"to {above['share_of_bound'].max():.2f} times it): {', '.join(above['case'])}."
        )
    negative = good[good["equivalent_damping_n_s_m3"] <= good["equivalent_damping_error_n_s_m3"]]
    if len(negative):
        warnings.append(
            f"{len(negative)} of {len(cases)} coupon cases dissipate no more than their own error: "
            f"{', '.join(negative['case'])}."
        )
    return warnings
