"""The rounds of the random drive: the panel decides how its coupons are shaken next.

Round 0 drives every coupon with the motion that its patch would have if the bed were a perfectly
inelastic body (`damping.thrown_bed`). Each further one computes the responses with the best linear
approximation of all records whose motion was about that of the last (`damping.best_linear`), and
drives the coupons with the motions that agree with them, for as long as the wanted accuracy takes.
"""

from __future__ import annotations

import math
import sys
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.coupon.from_study import random_legs
from pidpanel.coupon.random_runs import RandomRun, Record
from pidpanel.damping.best_linear import Leg, approximate
from pidpanel.damping.random_reading import RandomReading, to_rows
from pidpanel.damping.surface_cases import clear_gap
from pidpanel.damping.thrown_bed import ThrownBed
from pidpanel.random_round import PatchDrive, RandomRound, record_name
from pidpanel.response.from_study import PanelFiles, PanelInSound, read_panel_in_sound
from pidpanel.response.random_motions import Key, Solved, agreeing, rms_velocity, solve
from pidpanel.study import CouponStudy, Study, StudyError
from pidpanel.study.damping import RandomDrive
from pidpanel.third_octaves import edge_frequency

BULK = 0.46
"""Volume of the particles over that of a full cell, for the first motion alone: 2 mm spheres in
6.35 mm cells."""

START = 0.1
"""Velocity from which the first one is searched [m/s]; it does not depend on that."""

MOVED = 0.01
"""Change of an rms acceleration from round to round below which motion and damping agree [1]."""

ALIKE = 0.1
"""Change of ln of a patch's rms acceleration up to which records count together: C_e falls about
as fast as the motion rises, and an rms acceleration changes by a quarter of that."""

SCATTER = 0.03
"""Standard error of an rms acceleration that one second of one cell leaves [1]: 1.1 % of the
paper's panel at half fill, 136.7 dB, with six cells."""

AGREED = 3
"""Rounds after which motion and damping agree: as many as acrylic took at 115 to 150 dB and
steel, on small panels."""


def first_round(study: Study, panel: PanelInSound) -> RandomRound:
    """Return round 0: the motions that agree with what inelastic bodies would do."""
    edges = band_edges(study.response.frequency_hz)
    expected = {key: partial(bed.reading, edges) for key, bed in beds(study).items()}
    solved = agreeing(study, panel, expected, dict.fromkeys(expected, START))
    drives = [
        PatchDrive(
            label=str(number),
            scenario=scenario.label,
            patch=filling.patch,
            damper=str(filling.damper),
            fill_fraction=_fill(filling.fill_fraction),
            period=study.damping.random.time_s,
            phases=number,
        ).with_motion(*solved[scenario.label].motions[filling.patch])
        for number, (scenario, filling, _) in enumerate(study.random_coupons())
    ]
    return RandomRound(0, tuple(drives), {label: one.rms_g for label, one in solved.items()})


def beds(study: Study) -> dict[Key, ThrownBed]:
    """Return the inelastic body in the place of every coupon that is driven at random."""
    found = {}
    for scenario, filling, coupon in study.random_coupons():
        fill = _fill(filling.fill_fraction)
        *across, along = coupon.gravity_direction
        found[scenario.label, filling.patch] = ThrownBed(
            mass=BULK * coupon.particles.effective_density(coupon.diameters[0])
            * coupon.cell.depth * fill,
            gap=coupon.cell.depth * float(clear_gap(np.array(fill))),
            gravity=coupon.gravity * abs(along) / math.hypot(*across, along),
        )  # fmt: skip
    return found


def next_round(
    rounds: Sequence[RandomRound],
    study: Study,
    panel: PanelInSound,
    told: Mapping[Key, Told],
) -> RandomRound:
    """Return the round after some others.

    Parameters
    ----------
    rounds
        All before, in order.
    study, panel
        The study, and its panel in the sound.
    told
        By the records so far, of every coupon.
    """
    before, wanted = rounds[-1], study.damping.random
    solved = solve(study, panel, {key: one.reading for key, one in told.items()})
    shaken = {drive.scenario for drive in before.wanted}
    drives, again = [], set()
    for drive in before.drives:
        if drive.scenario not in shaken:  # nothing new is known of it
            drives.append(drive)
            continue
        own = solved[drive.scenario]
        was = before.acceleration_rms_g[drive.scenario]
        moved = max(abs(own.rms_g[name] / was[name] - 1) for name in was)
        spent = [one.drive(drive.label).period for one in rounds]
        error = own.relative_error or 0.0
        good = moved <= MOVED and error <= wanted.relative_error
        period = 0.0 if good or not spent[-1] else next_period(wanted, spent, moved)
        if not good and not period:
            print(f"{drive.scenario}, {drive.patch}: {_short(own, moved, wanted)}", file=sys.stderr)
        if period:
            again.add(drive.scenario)
        drives.append(
            replace(
                drive,
                period=period,
                phases=drive.phases + len(before.drives),
                moved=moved,
                relative_error=error,
                reached=good,
            ).with_motion(*own.motions[drive.patch])
        )
    if again:
        bed = beds(study)
        expected = {
            key: partial(bed[key].carried, one.reading, one.velocity, one.exponent)
            for key, one in told.items()
            if key[0] in again
        }
        solved |= agreeing(study, panel, expected, {key: told[key].velocity for key in expected})
    drives = [
        drive.with_motion(*solved[drive.scenario].motions[drive.patch]) if drive.period else drive
        for drive in drives
    ]
    rms = {label: one.rms_g for label, one in solved.items()}
    return RandomRound(before.round + 1, tuple(drives), rms)


def next_period(wanted: RandomDrive, before: Sequence[float], moved: float) -> float:
    """Return the record of a round [s]; 0 where no time or no round is left.

    It is twice that of the round before once the motion is nearly found. It does not depend on
    the accuracy, so that a tighter one continues with the same records.

    Parameters
    ----------
    wanted
        Of the study.
    before
        Records of the rounds before [s].
    moved
        Largest change of an rms acceleration in the last of them [1].
    """
    last = before[-1] if before else wanted.time_s
    longest = wanted.max_time_s - sum(before)
    period = min(2 * last if before and moved <= ALIKE else last, longest)
    # whole hundredths of a second have whole numbers of samples, and round lines
    period = math.floor(100 * period + 1e-6) / 100
    return period if period >= wanted.time_s and len(before) < wanted.max_rounds else 0.0


def expected_rounds(wanted: RandomDrive, cells: int) -> tuple[int, float]:
    """Return how many rounds a patch will take, and the time of its records [s].

    Parameters
    ----------
    wanted
        Of the study.
    cells
        Of a packing.
    """
    needed = (SCATTER / wanted.relative_error) ** 2 / (cells * wanted.seeds)
    times: list[float] = []
    while period := next_period(wanted, times, 0.0):
        times.append(period)
        if len(times) >= AGREED and sum(times) >= needed:
            break
    return len(times), sum(times)


def expected_legs(study: CouponStudy, results: Path) -> tuple[list[tuple[RandomRun, float]], int]:
    """Return a leg of every packing that will be driven, with its time [s], and the rounds.

    Parameters
    ----------
    study
        The study; nothing is driven where it has no panel.
    results
        The folder ``results``: nothing is left where the last round is there.
    """
    if not isinstance(study, Study) or not study.random_coupons():
        return [], 0
    files = sorted((results / study.name / "random").glob("round*.json"))
    if any(RandomRound.read(file).is_last for file in files):
        return [], 0
    wanted, legs = study.damping.random, random_legs(study)
    each = [expected_rounds(wanted, run.bed.packing.count) for run in legs]
    times = [(run, time) for run, (_, time) in zip(legs, each, strict=True)]
    return times, max(number for number, _ in each)


def _short(own: Solved, moved: float, wanted: RandomDrive) -> str:
    error, packings = own.relative_error or 0.0, own.of_packings or 0.0
    says = f"rms accelerations known to {error:.1%}, moved by {moved:.1%} in the last round"
    if packings > wanted.relative_error:
        return f"{says}; {packings:.1%} is of the packings: raise damping.random.seeds"
    return f"{says}; raise damping.random.max_time_s or max_rounds"


def _fill(fill_fraction: float | None) -> float:
    if fill_fraction is None:  # the study asks for it with a coupon
        raise StudyError("a coupon without a fill fraction")
    return fill_fraction


# --------------------------------------------------------------------------------- records


@dataclass(frozen=True)
class Told:
    """What the records of one patch say.

    Attributes
    ----------
    reading
        C_e and m_a, of those whose motion was about that of the last.
    velocity
        Mean rms of these motions [m/s].
    exponent
        See `thrown_bed.ThrownBed.exponent_seen`.
    """

    reading: RandomReading
    velocity: float
    exponent: float


def told_by(
    drive: Sequence[PatchDrive],
    records: Sequence[Sequence[Record]],
    band: tuple[float, float],
    bed: ThrownBed,
) -> Told:
    """Return what the records of one patch say.

    Parameters
    ----------
    drive
        Of every round that has records, in order.
    records
        Of each of these rounds those of all packings.
    band
        Lowest and highest frequency [Hz].
    bed
        The inelastic body in the place of its particles.
    """
    last, edges = drive[-1].acceleration_rms, band_edges(band)
    alike = [abs(math.log(one.acceleration_rms / last)) <= ALIKE for one in drive]
    velocity = [rms_velocity(one.motion) for one in drive]
    each = [_reading([own], edges) for own in records]
    mean = np.average(
        np.log(velocity), weights=[a * d.period for a, d in zip(alike, drive, strict=True)]
    )
    return Told(
        _reading([own for own, one in zip(records, alike, strict=True) if one], edges),
        math.exp(mean),
        bed.exponent_seen(list(zip(each, velocity, strict=True))),
    )


def _reading(records: Sequence[Sequence[Record]], edges: Array) -> RandomReading:
    """What the records of all packings of some rounds say."""
    legs = [
        Leg(own[0].frequency, own[0].velocity, np.stack([one.force for one in own]))
        for own in records
    ]
    newest = records[-1]
    return RandomReading(
        approximate(legs, edges),
        weight=float(np.mean([one.mass_per_area for one in newest])),
        area=newest[0].area,
    )


def band_edges(band: tuple[float, float]) -> Array:
    """Return edges of third octaves within a band [Hz], its ends among them.

    A third octave that reaches less than a quarter of itself into the band joins the next.
    """
    low, high = band
    numbers = np.arange(math.floor(10 * math.log10(low)), math.ceil(10 * math.log10(high)) + 1)
    edges = edge_frequency(numbers)[:, 0]
    quarter = 10 ** (1 / 40)
    inner = edges[(edges > low * quarter) & (edges < high / quarter)]
    return np.concatenate([[low], inner, [high]])


def write_round(
    study: Study,
    files: PanelFiles,
    folder: Path,
    before: int,
    output: Path,
    impedance: Path,
) -> None:
    """Write a round of the random drive and, after the first, what the records say.

    Parameters
    ----------
    study
        With a reading that drives coupons at random.
    files
        Of the stages upstream.
    folder
        ``random``: rounds and records so far.
    before
        How many rounds there are before.
    output, impedance
        ``random/round<n>.json`` and ``random/impedance<n>.csv``.

    Raises
    ------
    StudyError
        For a study without such a coupon.
    """
    if not study.random_coupons():
        raise StudyError(f"{study.name}: damping.readings: no coupon to drive at random")
    panel = read_panel_in_sound(study, files, study.response.radiation)
    if not before:
        first_round(study, panel).write(output)
        impedance.write_text("")
        return
    rounds = [RandomRound.read(folder / f"round{number}.json") for number in range(before)]
    seeds = range(1, study.damping.random.seeds + 1)
    bed, told = beds(study), {}
    for drive in rounds[0].drives:
        key = drive.scenario, drive.patch
        driven = [one for one in rounds if one.drive(drive.label).period > 0]
        records = [
            [Record.read(folder / record_name(one.round, drive.label, seed)) for seed in seeds]
            for one in driven
        ]
        own = [one.drive(drive.label) for one in driven]
        told[key] = told_by(own, records, study.response.frequency_hz, bed[key])
    found = next_round(rounds, study, panel, told)
    rows: list[dict[str, Any]] = []
    for drive in found.drives:
        reading = told[drive.scenario, drive.patch].reading
        patch = {"scenario": drive.scenario, "patch": drive.patch}
        rows += to_rows(replace(reading, agreed=drive.reached), patch)
    pd.DataFrame(rows).to_csv(impedance, index=False, float_format="%.8g")
    found.write(output)
