"""Results of tests that have been made, beside what the runs show of the same."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array
from pidpanel.columns import ColumnsError, in_kilohertz
from pidpanel.damping.measured import amplitudes_g, measured_values
from pidpanel.damping.table_files import FREQUENCY, read_columns
from pidpanel.margin.next_test import Observable
from pidpanel.margin.observations import OCTAVE, octave_levels
from pidpanel.margin.update.posterior import Result
from pidpanel.measurement.from_study import read_study_file
from pidpanel.solve.bands import band_rms, whole_third_octaves
from pidpanel.sound.from_study import spectrum_of
from pidpanel.sound.spectrum import Spectrum
from pidpanel.sound.table import read_spectrum
from pidpanel.study import Study
from pidpanel.study.mistakes import Keys, Mistake, read_at
from pidpanel.study.uncertain import SHIFT, SPECTRUM, judged_scenarios
from pidpanel.study.update import (
    AcousticTest,
    CouponTest,
    MicrophoneTest,
    ModalTest,
    judged_like,
    scenario_of_test,
    tested_scenarios,
)

LINES_PER_BAND = 50  # of the spectrum of a test
FARTHEST_DB = 6.0  # overall level of measured sound from that of its scenario


class CouponTones(NamedTuple):
    """C_e of a coupon at tones, (n,) each."""

    frequency: Array  # [Hz]
    acceleration_g: Array
    damping: Array  # [N s/m³]
    error: Array  # relative


def coupon_tones(test: CouponTest) -> CouponTones:
    """Read the file of a coupon.

    Raises
    ------
    ColumnsError
        With all faults of the file.
    """
    columns = read_columns(test.file, scattered=True)
    gamma = amplitudes_g(columns)
    damping, error, *_ = measured_values(columns)
    if gamma is None:
        raise ColumnsError([f"{test.file}: needs a column of amplitudes, such as acceleration_g"])
    used = damping > 0
    if not used.any():
        raise ColumnsError([f"{test.file}: no row has C_e above 0"])
    relative = np.where(np.isnan(error), test.relative_error or np.nan, error / damping)[used]
    if np.isnan(relative).any():
        raise ColumnsError([f"{test.file}: has no errors of C_e; state relative_error"])
    return CouponTones(columns[FREQUENCY][used], gamma[used], damping[used], relative)


def level_of_test(study: Study) -> float | None:
    """Return the level of acoustic tests with dampers over that of the margin [dB], if any."""
    spectrum, judged = spectrum_of(study.acoustics), judged_scenarios(study)
    for scenario in tested_scenarios(study):
        like = judged[judged_like(scenario, judged) or 0]
        return _level(spectrum, scenario.oaspl_db) - _level(spectrum, like.oaspl_db)
    return None


def _level(spectrum: Spectrum, oaspl_db: float | None) -> float:
    """Return the level of a scenario over that of the study [dB]."""
    return 0.0 if oaspl_db is None else oaspl_db - spectrum.oaspl


def _third_levels(spectrum: Spectrum, edges: Array) -> Array:
    """Return levels of thirds (n_bands,) [dB]; NaN outside the spectrum."""
    low, high = spectrum.reach
    inside = (edges[:, 0] >= low * (1 - 1e-6)) & (edges[:, 1] <= high * (1 + 1e-6))
    levels = np.full(len(edges), np.nan)
    for number in np.flatnonzero(inside):
        first, last = np.clip(edges[number], low, high).tolist()
        lines = np.geomspace(first, last, LINES_PER_BAND)
        mean = band_rms(lines, spectrum.points(lines), lines[None, [0, -1]]) ** 2
        levels[number] = 10 * np.log10(max(mean.item(), 1e-30))
    return levels


class TestContext(NamedTuple):
    """What the runs of a study have to do with tests."""

    study: Study
    runs: Mapping[str, Array]  # what they show, by its name
    edges: Array  # (n_bands, 2) third octaves of the response [Hz]
    points: Sequence[str]
    coupon: Array | None  # (n_runs, n_tones) ln C_e at the tones of the coupon
    unseen: Sequence[slice]  # scores of the spectrum of the launch


def results_of(context: TestContext) -> list[Result]:
    """Return what has been measured, with what the runs show of the same."""
    update, results = context.study.update, []
    assert update is not None
    for title, test in (("modal survey", update.modal_survey), ("impact test", update.impact_test)):
        if test is not None:
            results.append(_modal(title, test, context.runs))
    if update.coupon is not None and context.coupon is not None:
        tones = coupon_tones(update.coupon)
        names = [f"C_e at {f:g} Hz, {g:.3g} g" for f, g in zip(*tones[:2], strict=True)]
        simulated = Observable(context.coupon, tones.error)
        results.append(Result("coupon on a shaker", simulated, np.log(tones.damping), names))
    if update.microphones is not None:
        nominal = _third_levels(spectrum_of(context.study.acoustics), context.edges)
        measured = _third_levels(read_spectrum(update.microphones.spectrum), context.edges)
        powers = {"level": 10 ** ((measured - nominal) / 10)}
        runs = {"level": 10 ** (context.runs["level"] / 10)}
        results.append(_of_octaves("microphones", powers, runs, update.microphones, context.edges))
    for title, acoustic in update.acoustic.items():
        results += _acoustic(context, title, acoustic)
    return results


def _modal(title: str, test: ModalTest, runs: Mapping[str, Array]) -> Result:
    values, simulated, errors, names = [], [], [], []
    for key, column, relative in (
        ("frequency_hz", "frequency", test.frequency_error),
        ("damping_ratio", "ratio", test.damping_ratio_error),
    ):
        for mode, value in getattr(test, key).items():
            values.append(np.log(value))
            simulated.append(np.log(runs[column][:, int(mode) - 1]))
            errors.append(relative or 0.0)
            names.append(f"{key.removesuffix('_hz').replace('_', ' ')} of mode {mode}")
    observable = Observable(np.stack(simulated, axis=1), np.array(errors))
    return Result(title, observable, np.array(values), names)


def _acoustic(context: TestContext, title: str, test: AcousticTest) -> Iterator[Result]:
    """Yield what the bare panel and that with dampers showed over the sound that they had."""
    study, judged = context.study, judged_scenarios(context.study)
    spectrum = spectrum_of(study.acoustics)
    for panel in ("bare", "damped"):
        powers, simulated = {}, {}
        for name in test.measurements:
            scenario, point = scenario_of_test(study, name), study.measurements[name].point
            if scenario.is_bare != (panel == "bare"):
                continue
            level = _level(spectrum, scenario.oaspl_db) * np.ones(len(context.edges))
            if test.spectrum is not None:
                nominal = _third_levels(spectrum, context.edges)
                level = _third_levels(read_spectrum(test.spectrum), context.edges) - nominal
            row = list(context.points).index(point)
            if panel == "damped":
                row += len(context.points) * (judged_like(scenario, judged) or 0)
                level -= _level(spectrum, scenario.oaspl_db)
            measured = read_study_file(study.measurements[name])
            low, high = measured.frequency[[0, -1]]
            inside = (context.edges[:, 0] >= low) & (context.edges[:, 1] <= high)
            power = np.full(len(context.edges), np.nan)
            if inside.any():
                rms = band_rms(measured.frequency, measured.psd, context.edges[inside])
                power[inside] = np.maximum(rms**2, 1e-30)
            powers[name] = power / 10 ** (level / 10)
            thirds = context.runs[f"{panel}_bands"][:, row] ** 2
            simulated[name] = thirds / 10 ** (context.runs["level"] / 10)
        if powers:
            result = _of_octaves(f"{title}, {panel}", powers, simulated, test, context.edges)
            observable = result.observable._replace(kind="acoustic", unseen=context.unseen)
            if panel == "damped":
                common = study.margin.test_errors.common_damping
                observable = observable._replace(common_damping=common)
            yield result._replace(observable=observable)


def _of_octaves(
    title: str, powers: Mapping[str, Array], simulated: Mapping[str, Array],
    test: AcousticTest | MicrophoneTest, edges: Array,
) -> Result:  # fmt: skip
    """Return levels of octaves that were measured, of powers in thirds (n_bands,)."""
    middle = np.sqrt(edges[::OCTAVE, 0] * np.append(edges[OCTAVE::OCTAVE, 0], edges[-1, 1]))
    level = np.concatenate([octave_levels(power, edges) for power in powers.values()])
    finite = np.isfinite(level)
    values = np.hstack([octave_levels(power, edges) for power in simulated.values()])[:, finite]
    names = [f"{name}, octave at {f:.0f} Hz" for name in powers for f in middle]
    error = np.full(values.shape[1], test.error_db)
    return Result(
        title, Observable(values, error, test.common_db, title), level[finite],
        [name for name, is_known in zip(names, finite, strict=True) if is_known],
    )  # fmt: skip


def _has_octave(edges: Array, low: float, high: float) -> bool:
    """Return whether an octave of thirds (n_bands, 2) lies within frequencies [Hz]."""
    inside = (edges[:, 0] >= low) & (edges[:, 1] <= high)
    return bool(np.logical_and.reduceat(inside, np.arange(0, len(edges), OCTAVE)).any())


def mistakes_of_files(study: Study) -> Iterator[Mistake]:
    """Yield what is wrong with the files of the section ``update``."""
    update = study.update
    if update is None or study.sound is None:
        return
    low, high = study.response.frequency_hz
    if update.coupon is not None:
        coupon, keys = update.coupon, ("update", "coupon", "file")
        tones = yield from read_at(keys, lambda: coupon_tones(coupon))
        if tones is not None and not np.all((tones.frequency >= low) & (tones.frequency <= high)):
            message = f"must have {low:g} to {high:g} Hz, the frequencies of the response"
            yield Mistake(keys, message + "; in kHz?" * in_kilohertz(tones.frequency, low, high))
    if update.microphones is not None and not {SPECTRUM, SHIFT} & {*study.uncertain}:
        message = f"needs a spread of {SPECTRUM} or {SHIFT}"
        yield Mistake(("update", "microphones"), message)
    edges, spectrum = whole_third_octaves(low, high)[1], spectrum_of(study.sound)
    for title, test in update.acoustic.items():
        for index, name in enumerate(test.measurements):
            where: Keys = ("update", "acoustic", title, "measurements", index)
            measurement = study.measurements[name]
            measured = yield from read_at(where, partial(read_study_file, measurement))
            if measured is not None and not _has_octave(edges, *measured.frequency[[0, -1]]):
                yield Mistake(where, f"{measurement.file}: has no whole octave of the response")
    tests: list[tuple[Keys, Path, float]] = []
    if update.microphones is not None:
        tests.append((("microphones",), update.microphones.spectrum, 0.0))
    for title, test in update.acoustic.items():
        if test.spectrum is not None:
            scenario = scenario_of_test(study, test.measurements[0])
            level = _level(spectrum, scenario.oaspl_db)
            tests.append((("acoustic", title), test.spectrum, level))
    for way, file, level in tests:
        where = ("update", *way, "spectrum")
        sound = yield from read_at(where, partial(read_spectrum, file))
        if sound is not None and abs(sound.oaspl - spectrum.oaspl - level) > FARTHEST_DB:
            message = f"sums to {sound.oaspl:.1f} dB; must be within {FARTHEST_DB:g} dB of "
            yield Mistake(where, f"{message}{spectrum.oaspl + level:.1f}, as computed; in Pa?")
        elif sound is not None and not _has_octave(edges, *sound.reach):
            yield Mistake(where, "has no whole octave of the response")
