"""The margin of a study: the only module of the stage that reads it."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array, variable
from pidpanel.margin.assessment import (
    ENOUGH,
    PointAnswer,
    governing,
    range_row,
    share_rows,
)
from pidpanel.margin.chaos import fitted
from pidpanel.margin.damping_table import LEAST
from pidpanel.margin.inputs.from_study import BROADBAND, UncertainStudy
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
from pidpanel.margin.samples import DRAWS, columns_of, scores
from pidpanel.margin.spread_dampers import SpreadDampers
from pidpanel.margin.spread_panel import SpreadPanel
from pidpanel.margin.update.from_study import (
    TestContext,
    results_of,
)
from pidpanel.margin.update.updated import Updated, input_rows
from pidpanel.margin.waves import WaveMatrix
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.progress import map_in_forks
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.response.results import write_csv
from pidpanel.solve.lines import frequency_grid
from pidpanel.sound.field_files import ADDED_VOLUME, DIFFUSE, MODAL_FORCE
from pidpanel.sound.from_study import WETTED_SIDES, sound_tables, spectrum_of
from pidpanel.sound.spectrum import pressure_psd
from pidpanel.sound.wavenumber_table import Table
from pidpanel.study import Study
from pidpanel.study.structure import Structure
from pidpanel.study.uncertain import SHIFT, SPECTRUM, judged_scenarios, varied
from pidpanel.study.update import MODES_SEEN

ENDS = 2.0  # scores of the panels whose shapes the family has besides the nominal ones
FEWER_RUNS = (128,)  # after which the surrogate may be good enough
COUPON_TONES = 4
TESTED = 96  # runs that are also made at the level of a test


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
            keys = self.uncertain.key_scores(row) if number >= 0 else None
            layouts = self.dampers.layouts(keys, row)
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
        runs, a NetCDF file, and ranges, shares and next_test, CSV tables; inputs and tests with
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
                fitted(samples, results[panel][:, s, p], is_log=True, draws=DRAWS,
                       base=spread.uncertain.band_power(
                           nominal.band_rms[0 if panel == "bare" else 1 + s, p])),
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
    layout_of = {scenario.label: scenario.layout_label for scenario in judged_scenarios(study)}
    main, edges = governing(cases, size, layout_of), uncertain.band_edges
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
        tables["tests"] = updated.tests
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
