"""The margin of a study: the only module of the stage that reads it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array, variable
from pidpanel.damping.broadband import EXACT, BroadbandError
from pidpanel.damping.models import FilledDamper
from pidpanel.margin.assessment import (
    ENOUGH,
    PointAnswer,
    governing,
    range_row,
    share_rows,
)
from pidpanel.margin.chaos import fitted
from pidpanel.margin.damping_table import LEAST
from pidpanel.margin.next_test import test_rows
from pidpanel.margin.observations import measurements_of
from pidpanel.margin.runs import (
    LINES_PER_BANDWIDTH,
    AcousticMedium,
    Answers,
    DampedLayout,
    RunInputs,
    UnitPanel,
    answers,
)
from pidpanel.margin.samples import DRAWS, Group, columns_of, joined_keys, leading, scores
from pidpanel.margin.spread_dampers import ERROR_TERMS, TEST_DB, SpreadDampers
from pidpanel.margin.spread_panel import SpreadPanel
from pidpanel.margin.update.from_study import (
    CouponTones,
    TestContext,
    coupon_tones,
    level_of_test,
    results_of,
)
from pidpanel.margin.update.updated import Updated, input_rows
from pidpanel.margin.waves import WaveMatrix
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.progress import map_in_forks
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.response.from_study import dampers_of_scenarios, scenario_of
from pidpanel.response.results import write_csv
from pidpanel.solve.bands import whole_third_octaves
from pidpanel.solve.lines import frequency_grid
from pidpanel.sound.field_files import ADDED_VOLUME, DIFFUSE, MODAL_FORCE
from pidpanel.sound.from_study import WETTED_SIDES, sound_tables, spectrum_of
from pidpanel.sound.spectrum import pressure_psd
from pidpanel.sound.wavenumber_table import Table
from pidpanel.study import Study
from pidpanel.study.structure import Structure
from pidpanel.study.uncertain import SHIFT, SPECTRUM, correlation_matrix, judged_scenarios, varied
from pidpanel.study.update import MODES_SEEN

ENDS = 2.0  # scores of the panels whose shapes the family has besides the nominal ones
FEWER_RUNS = (128,)  # after which the surrogate may be good enough
COUPON_TONES = 4
BROADBAND = "damping models under broadband sound"
QUICK = ("dampers.", "scenarios.", "sound.shift_db")  # keys that leave the panel and its air
TESTED = 96  # runs that are also made at the level of a test


@dataclass(frozen=True)
class UncertainStudy:
    """A study with its inputs as standard normal scores."""

    study: Study
    damping: Path | None  # folder of surfaces of simulated tones

    @cached_property
    def keys(self) -> list[str]:
        """Keys with a spread but that of the spectrum."""
        return [key for key in self.study.uncertain if key != SPECTRUM]

    @cached_property
    def band_edges(self) -> Array:
        """(n_bands, 2) third octaves of the response [Hz]."""
        return whole_third_octaves(*self.study.response.frequency_hz)[1]

    @cached_property
    def groups(self) -> list[Group]:
        """The groups of inputs: keys, the spectrum, errors of damping models."""
        uncertain, groups = self.study.uncertain, []
        correlation = correlation_matrix(self.study)
        for numbers in joined_keys(correlation):
            names = [self.keys[number] for number in numbers]
            mixing = np.zeros((len(self.keys), len(numbers)))
            mixing[numbers] = np.linalg.cholesky(correlation[np.ix_(numbers, numbers)])
            sources = "; ".join(dict.fromkeys(uncertain[name].source for name in names))
            changes_panel = not all(name.startswith(QUICK) for name in names)
            groups.append(Group(" and ".join(names), sources, mixing, changes_panel))
        if (spread := uncertain.get(SPECTRUM)) is not None:
            octave = np.log2(self.band_edges).mean(axis=1)
            distance = np.abs(octave[:, None] - octave) / (spread.correlation_octaves or 1.0)
            mixing = spread.deviation * leading(np.exp(-distance))
            groups.append(Group(SPECTRUM, spread.source, mixing))
        if np.any(self.broadband):
            mixing = np.zeros((0, len(BroadbandError._fields)))
            groups.append(Group(BROADBAND, "their stated error", mixing))
        for name in self.error_names:
            mixing = np.zeros((0, ERROR_TERMS))
            groups.append(Group(f"damping model of {name}", "its stated error", mixing))
        return groups

    @cached_property
    def error_names(self) -> list[str]:
        """Dampers whose damping model states an error, by name."""
        dampers = [damper for scenario in self.dampers() for damper in scenario.values()]
        return list(dict.fromkeys(d.name for d in dampers if d.model.nodes is not None))

    @cached_property
    def broadband(self) -> Array:
        """(n_scenarios, 2) `BroadbandError` of each judged scenario, the largest of its dampers."""
        return np.array([
            np.max([EXACT, *(damper.model.broadband_error for damper in dampers.values())], axis=0)
            for dampers in self.dampers()
        ])  # fmt: skip

    def log_broadband(self, scores: Array, effect: Array) -> Array:
        """Return the error of ln g rms under broadband sound (n_scenarios, …).

        ``effect`` (n_scenarios, …) is that of the damping on ln g rms.
        """
        z = np.zeros(2)
        for group, part in zip(self.groups, columns_of(self.groups), strict=True):
            if group.name == BROADBAND:
                z = scores[part]
        share, rest = (self.broadband * z).T.reshape(2, -1, *(1,) * (effect.ndim - 1))
        return np.asarray(share * effect + rest)

    @property
    def size(self) -> int:
        """Number of scores."""
        return sum(group.size for group in self.groups)

    @property
    def error_columns(self) -> dict[str, slice]:
        """Scores of the error of each damper."""
        start = self.size - ERROR_TERMS * len(self.error_names)
        return {
            name: slice(start + number * ERROR_TERMS, start + (number + 1) * ERROR_TERMS)
            for number, name in enumerate(self.error_names)
        }

    def values(self, scores: Array) -> dict[str, float]:
        """Return the values of the keys at scores of `groups` (n,)."""
        z = self.key_scores(scores)
        spreads = self.study.uncertain
        return {key: spreads[key].value(z[n]) for n, key in enumerate(self.keys)}

    def key_scores(self, scores: Array) -> Array:
        """Return standard normal scores of the keys."""
        total = np.zeros(len(self.keys))
        for group, part in zip(self.groups, columns_of(self.groups), strict=True):
            if len(group.mixing) == len(total) and group.name != SPECTRUM:
                total += group.mixing @ scores[part]
        return total

    def levels(self, scores: Array) -> Array:
        """Return the deviation of the level of each band (n_bands,) [dB]."""
        for group, part in zip(self.groups, columns_of(self.groups), strict=True):
            if group.name == SPECTRUM:
                return group.mixing @ scores[part]
        return np.zeros(len(self.band_edges))

    def all_levels(self, scores: Array) -> Array:
        """Return `levels` with the deviation of ``sound.shift_db``."""
        stated = self.study.acoustics.shift_db
        return self.levels(scores) + self.values(scores).get(SHIFT, stated) - stated

    def dampers(self, end: tuple[int, float] | None = None) -> list[dict[str, FilledDamper]]:
        """Return the dampers by patch of each judged scenario, with one key at a score."""
        study = self.study if end is None else self.at_end(*end)
        damper_of = dampers_of_scenarios(study, self.damping, None)
        return [
            dict(scenario_of(study, scenario, scenario.label, damper_of).dampers)
            for scenario in judged_scenarios(study)
        ]

    @cached_property
    def test_db(self) -> float:
        """Level of an acoustic test over that of the study [dB]."""
        level = level_of_test(self.study)
        return TEST_DB if level is None else level

    @cached_property
    def coupon(self) -> CouponTones | None:
        """What was measured of a coupon."""
        update = self.study.update
        return coupon_tones(update.coupon) if update and update.coupon else None

    @property
    def factors(self) -> list[float]:
        """PSD of the sound of each judged scenario over that of the study."""
        spectrum = spectrum_of(self.study.acoustics)
        levels = [scenario.oaspl_db for scenario in judged_scenarios(self.study)]
        return [1.0 if db is None else spectrum.pressure_factor(db) for db in levels]

    def at_end(self, number: int, z: float) -> Study:
        """Return the study with one key at a score."""
        key = self.keys[number]
        return varied(self.study, {key: self.study.uncertain[key].value(z)})


def _studied(study: Study) -> StudiedPanel:
    if isinstance(study.panel, Structure):
        raise TypeError("uncertain: a structure has its own modes")
    return StudiedPanel(study.panel)


def _real(table: Table) -> Callable[[Array], Array]:
    """Return the matrix of a table over wavenumber; it is real in a diffuse field."""
    return lambda k: np.asarray(table.matrix(k).real, np.float64)


class SpreadStudy:
    """A study over the spread of its inputs: runs at any scores."""

    def __init__(self, study: Study, damping: Path | None, samples: Array | None = None) -> None:
        self.uncertain = uncertain = UncertainStudy(study, damping)
        if samples is None:
            samples = scores(uncertain.groups, study.margin.runs_at_most)
        self.samples = samples
        ends = [uncertain.at_end(n, z) for n in range(len(uncertain.keys)) for z in (-ENDS, ENDS)]
        self._first = 1 + len(ends)
        drawn = [varied(study, uncertain.values(row)) for row in samples]
        self._studies = [study, *ends, *drawn]
        self._panels = [_studied(entry) for entry in self._studies]
        self._medium_of = [entry.wave_speed for entry in self._studies]
        highest = study.response.frequency_hz[1]
        self.panel = SpreadPanel(
            self._panels, self._first, highest, study.damper_masses(with_rows=True),
            2 * np.pi * highest / min(self._medium_of),
        )  # fmt: skip
        self.medium = self._medium()
        self.dampers = SpreadDampers(uncertain, self.panel, self.inputs(0), self.medium)

    def _medium(self) -> AcousticMedium:
        """Return sound and air to the largest wavenumber of all studies."""
        slow = self._studies[int(np.argmin(self._medium_of))]
        slow = self.uncertain.study.model_copy(update={"sound": slow.sound})
        is_wet = slow.radiation != "none"
        tables = sound_tables(slow, self.panel.basis, air=is_wet)
        low, high = slow.response.frequency_hz
        ends = 2 * np.pi * low / max(self._medium_of), 2 * np.pi * high / min(self._medium_of)
        length = float(np.linalg.norm(np.ptp(self.panel.basis.vertex_position, axis=0)))
        waves = {
            name: WaveMatrix.decomposed(_real(table), *ends, length)
            for name, table in tables.items()
        }
        force = waves[MODAL_FORCE]
        if not is_wet:
            return AcousticMedium(force, None, None, 0)
        air = waves.get(DIFFUSE, force), waves.get(ADDED_VOLUME)
        return AcousticMedium(force, *air, WETTED_SIDES[slow.radiation])

    def inputs(self, number: int) -> RunInputs:
        """Return the inputs of a study; the level has no deviation."""
        study, edges = self._studies[number], self.uncertain.band_edges
        basis, vectors = self.panel.modes(number, self._panels[number], study.panel.modal_damping)
        sound, ends = study.acoustics, study.response.frequency_hz
        jumps = np.concatenate([spectrum_of(sound).jumps, edges[1:, 0]])
        sharpest = study.panel.modal_damping.smallest(*ends)
        lines = frequency_grid(*ends, sharpest, (), jumps, LINES_PER_BANDWIDTH)
        rows = self.panel.patch_rows(self._panels[number])
        return RunInputs(
            lines, basis, vectors, self.panel.basis.shape_at_points, rows, self.panel.area,
            self._pressure(number, lines), sound.air_density_kg_m3, sound.speed_m_s,
        )  # fmt: skip

    def _pressure(self, number: int, lines: Array) -> Array:
        """Return S of the sound of a study on lines (nf,) [Pa²/Hz]."""
        sound = self._studies[number].acoustics
        return pressure_psd(spectrum_of(sound), lines, sound.reference, sound.faces)

    def run(self, number: int) -> tuple[Answers, RunInputs, list[DampedLayout]]:
        """Return answers, inputs and layouts of a sample; −1 for the nominal inputs."""
        return next(self.runs([number]))

    def runs(
        self, numbers: Sequence[int]
    ) -> Iterator[tuple[Answers, RunInputs, list[DampedLayout]]]:
        """Yield `run` of samples that have the panel of the first."""
        inputs = self.inputs(self._first + numbers[0] if numbers[0] >= 0 else 0)
        panel = UnitPanel.solved(inputs, self.medium, self.dampers.patches)
        edges = self.uncertain.band_edges
        for number in numbers:
            row = np.zeros(self.uncertain.size)
            if number >= 0:
                row = self.samples[number]
                band = np.searchsorted(edges[:, 0], inputs.frequency, "right") - 1
                deviation = self.uncertain.levels(row)[np.clip(band, 0, len(edges) - 1)]
                pressure = self._pressure(self._first + number, inputs.frequency)
                inputs = inputs._replace(pressure=pressure * 10 ** (deviation / 10))
            layouts = self.dampers.layouts(self.uncertain.key_scores(row), row)
            update = self.uncertain.study.update
            if number >= TESTED and not (update and update.acoustic):
                layouts = layouts[: len(self.dampers.scenarios)]
            yield answers(inputs, panel, layouts, edges, self.dampers.near), inputs, layouts

    def coupon(self, samples: Array) -> Array | None:
        """Return ln C_e (n, n_tones) of the coupon that was measured, at samples of the scores."""
        tones, update = self.uncertain.coupon, self.uncertain.study.update
        if tones is None or update is None or update.coupon is None:
            return None
        places = [(n, patch) for n, part in enumerate(self.dampers.scenarios) for patch in part]
        named = update.coupon.patch or places[0][1]
        number = next(n for n, patch in places if patch == named)
        place, values = list(self.dampers.scenarios[number]).index(named), []
        for row in samples:
            layout = self.dampers.layouts(self.uncertain.key_scores(row), row)[number]
            points = zip(tones.frequency, tones.acceleration_g.tolist(), strict=True)
            read = [layout.dampers[place](np.array([f]), gamma)[0] for f, gamma in points]
            values.append(np.log(np.maximum(np.concatenate(read), LEAST)))
        return np.array(values)


def _results(
    study: SpreadStudy, count: int, done: list[dict[str, Array]]
) -> list[dict[str, Array]]:
    """Return what runs up to a number show; those that are done are kept."""
    scenarios = len(study.dampers.scenarios)
    tones = np.geomspace(*study.uncertain.study.response.frequency_hz, COUPON_TONES + 2)[1:-1]

    def results(
        number: int, answer: Answers, inputs: RunInputs, layouts: list[DampedLayout]
    ) -> dict[str, Array]:
        natural, ratio = inputs.basis.natural_frequency, inputs.basis.damping_ratio
        elastic = np.flatnonzero(natural > 0)[:MODES_SEEN]
        read = [
            np.log(np.maximum(damping(tones, float(np.exp(gamma)))[0], LEAST))
            for layout, near in zip(layouts[:scenarios], study.dampers.near, strict=False)
            for damping, gamma in zip(layout.dampers, near, strict=True)
        ]
        factor = np.sqrt([layout.factor for layout in layouts[:scenarios]])
        bare, damped = factor[:, None] * answer.rms[0], answer.rms[1 : scenarios + 1]
        error = study.uncertain.log_broadband(study.samples[number], np.log(bare / damped))
        values = {
            "bare": bare,
            "damped": damped * np.exp(error),
            "bare_bands": answer.band_rms[0],
            "frequency": natural[elastic],
            "ratio": ratio[elastic],
            "level": study.uncertain.all_levels(study.samples[number]),
            "coupon": np.concatenate([*read, np.zeros(0)]),
        }
        if len(layouts) > scenarios:
            bands = answer.band_rms[scenarios + 1 :] * np.exp(error)[:, :, None]
            values["damped_bands"] = bands.reshape(-1, bands.shape[2])
        return values

    def panel_runs(numbers: Sequence[int]) -> list[dict[str, Array]]:
        return [results(n, *run) for n, run in zip(numbers, study.runs(numbers), strict=True)]

    numbers = [range(n, min(n + DRAWS, count)) for n in range(len(done), count, DRAWS)]
    return done + [values for runs in map_in_forks(panel_runs, numbers) for values in runs]


def write_margin(study: Study, damping: Path | None, output: Files) -> None:
    """Write runs, ranges, shares and what further tests would leave.

    Parameters
    ----------
    damping
        Folder of the surfaces of simulated tones; None for a study without any.
    output
        runs, a NetCDF file, and ranges, shares and next_test, CSV tables; inputs and update with
        the section ``update``.
    """
    spread = SpreadStudy(study, damping)
    limit = len(spread.samples)
    nominal, _, layouts = spread.run(-1)
    labels = [scenario.label for scenario in judged_scenarios(study)]
    points = list(spread.panel.basis.point_names)
    limits = {name: limit.rms_g or np.nan for name, limit in study.limits.items()}
    runs: list[dict[str, Array]] = []
    for count in [*(n for n in FEWER_RUNS if n < limit), limit]:
        runs = _results(spread, count, runs)
        results = {name: np.array([run[name] for run in runs if name in run]) for name in runs[0]}
        samples = spread.samples[:count]
        cases = [
            PointAnswer(
                label, point, panel,
                float(nominal.rms[0, p] * np.sqrt(layouts[s].factor) if panel == "bare"
                      else nominal.rms[1 + s, p]),
                results[panel][:, s, p], limits.get(point, np.nan),
                fitted(samples, results[panel][:, s, p], is_log=True, draws=DRAWS),
            )
            for s, label in enumerate(labels)
            for p, point in enumerate(points)
            for panel in ("bare", "damped")
        ]  # fmt: skip
        worst = min(case.chaos.q2 for case in cases)
        print(f"{count} runs: Q² at least {worst:.4f}", file=sys.stderr)
        if worst >= ENOUGH:
            break
    tables = _tables(spread, results, cases)
    for name, rows in tables.items():
        write_csv(getattr(output, name), pd.DataFrame(rows))
    _runs_dataset(spread, results, samples, labels, points).assign_attrs(stamp(study)).to_netcdf(
        output.runs, engine="scipy"
    )


def _tables(
    spread: SpreadStudy, runs: Mapping[str, Array], cases: Sequence[PointAnswer]
) -> dict[str, list[dict[str, Any]]]:
    """Return ranges, shares and next tests with the stated spreads, and after tests."""
    uncertain, study = spread.uncertain, spread.uncertain.study
    groups, size, factor = uncertain.groups, uncertain.size, study.margin.factor_of_safety
    names, sources, parts = [g.name for g in groups], [g.source for g in groups], columns_of(groups)
    samples, errors = spread.samples[: len(runs["level"])], [*uncertain.error_columns.values()]
    errors += [part for name, part in zip(names, parts, strict=True) if name == BROADBAND]
    main, edges = governing(cases, size), uncertain.band_edges
    unseen = [part for name, part in zip(names, parts, strict=True) if name in (SPECTRUM, SHIFT)]
    possible = measurements_of(runs, study.margin.test_errors, edges, unseen, uncertain.test_db)
    stated = {"inputs": "stated"}
    tables = {
        "ranges": [stated | range_row(case, case.drawn(size), factor) for case in cases],
        "shares": [stated | row for case in cases
                   for row in share_rows(case, names, sources, parts)],
        "next_test": [stated | main.place | row
                      for row in test_rows(main, main.drawn(size), samples, possible, errors)],
    }  # fmt: skip
    if study.update is not None:
        points = spread.panel.basis.point_names
        context = TestContext(study, runs, edges, points, spread.coupon(samples), unseen)
        updated, updates = Updated.by(samples, results_of(context), errors), {"inputs": "updated"}
        tables["ranges"] += [updates | range_row(c, updated.drawn(c), factor) for c in cases]
        tables["shares"] += [updates | r for r in updated.share_rows(main, names, sources, parts)]
        further = test_rows(main, updated.drawn(main), samples, possible, errors, updated.normal)
        tables["next_test"] += [updates | main.place | row for row in further]
        values = [
            np.array([list(uncertain.values(row).values()) for row in scores])
            for scores in (updated.stated, updated.scores)
        ]
        tables["inputs"] = input_rows(uncertain.keys, *values)
        tables["update"] = updated.tests
    return tables


def _runs_dataset(
    spread: SpreadStudy,
    results: Mapping[str, Array],
    samples: Array,
    labels: list[str],
    points: list[str],
) -> xr.Dataset:
    uncertain = spread.uncertain
    values = [list(uncertain.values(row).values()) for row in samples]
    dims = "run scenario point"
    return xr.Dataset(
        {
            "score": variable("run score_number", samples, "1", "standard normal scores"),
            "value": variable("run key", np.array(values).reshape(len(samples), -1), "1", "inputs"),
            "level": variable("run band", results["level"], "dB", "deviation of the level"),
            "bare_rms": variable(dims, results["bare"], "g", "rms acceleration of the bare panel"),
            "damped_rms": variable(dims, results["damped"], "g", "rms acceleration with dampers"),
        },
        {"scenario": labels, "point": points, "key": uncertain.keys},
    )
