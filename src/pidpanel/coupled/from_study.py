"""The coupled runs of a study: the only module of the stage that knows it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled import carried, estimate_files, sound_record, tables
from pidpanel.coupled.beds import cpu_per_interval, mass_per_area, rayleigh_time_of
from pidpanel.coupled.coupled_panel import CoupledPanel, CoupledPatch
from pidpanel.coupled.estimate import ScenarioEstimate, estimate
from pidpanel.coupled.integration import Integration, PanelShapes
from pidpanel.coupled.loaded_shapes import LinearDamper, LoadedShapes, loaded_shapes
from pidpanel.coupled.pieces import StartedBed, integrated, run_identity, started
from pidpanel.coupled.record_files import IDENTITY, read_record, write_record
from pidpanel.coupled.segments import SettledRecord
from pidpanel.coupled.softening import (
    RmsMotion,
    Softened,
    softened_modulus,
    softening_bias,
    usual_modulus,
)
from pidpanel.coupled.stations import stations_of
from pidpanel.coupon.bed import Bed
from pidpanel.coupon.estimate import spheres_in
from pidpanel.coupon.from_study import bed_of
from pidpanel.coupon.liggghts.failures import EnergyNotClosed, FilesFailed
from pidpanel.damping.from_study import reading_of_damper
from pidpanel.panel.basis import PanelBasis, patch_areas
from pidpanel.panel.basis_files import read_basis
from pidpanel.panel.plate_files import StoredPlate, read_plate
from pidpanel.provenance import durable
from pidpanel.provenance.digests import stamp
from pidpanel.solve.bands import whole_third_octaves
from pidpanel.solve.basis_error import basis_shapes, modal_basis
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.panel import deflection_at_points
from pidpanel.solve.source import PatchParts
from pidpanel.sound.excitation import SoundExcitation
from pidpanel.sound.field_files import MODAL_FORCE, read_table
from pidpanel.sound.from_study import excitation_of, read_air
from pidpanel.sound.radiation import Air
from pidpanel.study import Filling, Scenario, Study
from pidpanel.study.coupon import Coupon
from pidpanel.study.damping import NEIGHBOURS_DB

ROWS_PER_PERIOD = 10.0
"""Rows of a record in a period of the highest frequency: what is linear between them is 3 % low
there, for which the sound is corrected."""

INTERVALS_PER_PERIOD = 60.0
"""Fewest intervals of the integration in a period of the highest frequency."""

LINES_PER_BANDWIDTH = 3.0
"""Of rms values within 1e-3."""

STEP_RAYLEIGH = 0.4
"""Time step over the Rayleigh time of the smallest sphere [1]: 0.1, 0.2 and 0.4 give the same
g rms within their scatter (docs/coupled.md)."""

BALANCE_LIMIT = 0.01
"""Largest share of the sound's energy that may be missing in a run [1]."""

PARTS = 64
"""Parts of a patch over which the own force is summed."""

BED_JSON = "bed.json"


@dataclass(frozen=True)
class CoupledScenario:
    """A scenario whose panel and particles are integrated together.

    Attributes
    ----------
    fillings
        Filled patches with a coupon, the coupon and its fill.
    """

    scenario: Scenario
    fillings: tuple[tuple[Filling, Coupon, float], ...]
    beds: tuple[tuple[Bed, ...], ...]

    @property
    def name(self) -> str:
        """Folder below ``results/<study>/coupled``."""
        return self.scenario.label


def coupled_scenarios(study: Study) -> dict[str, CoupledScenario]:
    """Return the scenarios of a study that are run, by their labels."""
    keys = study.damping.coupled if study.is_coupled else None
    if keys is None:
        return {}
    return {
        scenario.label: CoupledScenario(
            scenario,
            study.beds_of(scenario),
            tuple(
                tuple(
                    bed_of(coupon, fill, cells=keys.cells, seed=seed)
                    for _, coupon, fill in study.beds_of(scenario)
                )
                for seed in range(1, keys.runs + 1)
            ),
        )
        for scenario in study.coupled_scenarios()
        if scenario.label in (keys.scenarios or [scenario.label])
    }


def depends_on(study: Study, coupled: CoupledScenario) -> dict[str, Any]:
    """Return the values of a study on which the runs of a scenario depend."""
    dampers = {str(filling.damper) for filling in coupled.scenario.fillings}
    unused = {"coupon": {"sweep", "accuracy"}}
    response = {"frequency_hz", "damper_mass", "radiation", "air_mass"}
    return {
        "scenario": coupled.scenario.model_dump(),
        "coupled": study.damping.coupled.model_dump(exclude={"scenarios"}),
        "dampers": [study.all_dampers[name].model_dump(exclude=unused) for name in sorted(dampers)],
        "damping_ratio": study.panel.damping_ratio,
        "sound": study.sound.model_dump(),
        "response": study.response.model_dump(include=response),
    }


class CoupledFiles(NamedTuple):
    """Files of the stages upstream."""

    modes: Path
    modal_force: Path
    plate: Path
    air: Path | None


class CoupledTables(NamedTuple):
    """Tables of the stage."""

    summary: Path
    third_octaves: Path
    impedance: Path
    psd: Path


@dataclass(frozen=True)
class ExcitedPanel:
    """The panel of a study in its sound.

    Attributes
    ----------
    basis
        Modes and residual vectors of the panel.
    excitation
        The sound, at the level of the study.
    air
        The air that the panel moves; None where it is left out.
    """

    study: Study
    basis: PanelBasis
    plate: StoredPlate
    excitation: SoundExcitation
    air: Air | None

    @staticmethod
    def read(study: Study, files: CoupledFiles) -> ExcitedPanel:
        """Read the files of the stages upstream."""
        table = read_table(files.modal_force, MODAL_FORCE)
        return ExcitedPanel(
            study,
            read_basis(files.modes),
            read_plate(files.plate),
            excitation_of(study.sound, table),
            read_air(study, study.response.radiation, table, files.air),
        )

    @cached_property
    def modal(self) -> ModalBasis:
        """The shapes with the damping ratio of the bare panel."""
        highest = self.study.response.frequency_hz[1]
        return modal_basis(self.basis, self.study.panel.damping_ratio, highest)

    @cached_property
    def coarse_frequency(self) -> Array:
        """(nf,) lines that give rms values within 1e-3 [Hz]."""
        return frequency_grid(
            *self.study.response.frequency_hz,
            self.study.panel.damping_ratio,
            lines_per_bandwidth=LINES_PER_BANDWIDTH,
        )

    def factor(self, scenario: Scenario) -> float:
        """Return the PSD of the pressure of a scenario over that of the study."""
        level = scenario.oaspl_db
        return 1.0 if level is None else self.excitation.bands.pressure_factor(level)

    @cached_property
    def points(self) -> Array:
        """(p, n) the shapes at the points."""
        return deflection_at_points(self.basis)

    @property
    def diameter(self) -> float:
        """Of the panel [m]."""
        return float(np.hypot(*np.ptp(self.basis.vertex_position, axis=0)))

    @cached_property
    def _vectors(self) -> Array:
        none = np.zeros((len(self.plate.shapes), 0))
        return basis_shapes(self.basis, self.plate, none).vectors

    def patch(self, name: str, cell_area: float, shapes: LoadedShapes) -> CoupledPatch:
        """Return a patch with its simulated cells.

        Parameters
        ----------
        cell_area
            Of a cell [m²].
        """
        basis, keys = self.basis, self.study.damping.coupled
        index = basis.patch_names.index(name)
        per_cell = len(self.plate.quadrature_weight) // len(basis.cells)
        elements = np.flatnonzero(basis.cell_in_patch[index])
        rows = (elements[:, None] * per_cell + np.arange(per_cell)).ravel()
        position, weight = self.plate.quadrature_position[rows], self.plate.quadrature_weight[rows]

        def shape(points: Index) -> Array:
            return shapes.shape(np.asarray(self.plate.at_quadrature[rows[points]] @ self._vectors))

        stations = stations_of(position, weight, keys.stations)
        parts = stations_of(position, weight, min(PARTS, len(weight)))
        cells = keys.cells // keys.stations
        return CoupledPatch(
            shape=np.repeat(shape(stations.point), cells, axis=0),
            area=np.repeat(stations.area / cells, cells),
            position=np.repeat(position[stations.point], cells, axis=0),
            cell_area=cell_area,
            overlap=np.asarray(shapes.square(basis.patch_overlap[index])),
            parts=PatchParts(shape(parts.point), parts.area, position[parts.point]),
        )

    def shapes(self, coupled: CoupledScenario) -> LoadedShapes:
        """Return the shapes of the panel with what of a scenario is not integrated."""
        return loaded_shapes(
            self.modal,
            self.study.response.frequency_hz,
            self.air,
            [
                self._linear(coupled, one)
                for one in coupled.scenario.fillings
                if self._is_linear(one)
            ],
        )

    def _is_linear(self, filling: Filling) -> bool:
        return self.study.all_dampers[str(filling.damper)].coupon is None

    def _linear(self, coupled: CoupledScenario, filling: Filling) -> LinearDamper:
        """Return a damper without coupon, read at the motion of the bare patch."""
        reading = reading_of_damper(self.study.all_dampers[str(filling.damper)], None)
        if not self.study.response.damper_mass:
            reading = reading.without_mass()
        index = self.basis.patch_names.index(filling.patch)
        overlap, fill = self.basis.patch_overlap[index], filling.fill_fraction or 1.0
        acceleration = self._bare_acceleration(coupled, overlap / patch_areas(self.basis)[index])
        gamma = np.sqrt(2) * acceleration / STANDARD_GRAVITY

        def values(frequency: Array) -> tuple[Array, Array]:
            found = reading(frequency, fill, gamma)
            return found.equivalent_damping, found.apparent_mass

        return LinearDamper(overlap, values)

    def _bare_acceleration(self, coupled: CoupledScenario, weight: Array) -> float:
        """Return the rms acceleration of the bare panel [m/s²], √ of the mean of q̈ᵀ W q̈."""
        frequency, modal = self.coarse_frequency, self.modal
        inverse = 1 / modal.dynamic_stiffness(frequency)
        sound = self.factor(coupled.scenario) * self.excitation.spectrum(frequency)
        square = np.empty(len(frequency))
        for k, f in enumerate(frequency):
            force = self.excitation(np.array([f]))[0]
            moved = inverse[k][:, None] * force * inverse[k].conj()
            square[k] = sound[k] * np.sum(weight * moved.T).real
        return float(np.sqrt(np.trapezoid((2 * np.pi * frequency) ** 4 * square, frequency)))

    def in_sound(self, coupled: CoupledScenario) -> CoupledPanel:
        """Return the panel with the patches of a scenario, at its level."""
        factor, shapes = self.factor(coupled.scenario), self.shapes(coupled)
        return CoupledPanel(
            modal=shapes.modal,
            points=shapes.shape(self.points),
            patches=[
                self.patch(filling.patch, bed.packing.cell_area, shapes)
                for (filling, *_), bed in zip(coupled.fillings, coupled.beds[0], strict=True)
            ],
            spectrum=lambda frequency: factor * self.excitation.spectrum(frequency),
            modal_force=lambda frequency: shapes.square(self.excitation(frequency)),
        )

    def moduli(self, coupled: CoupledScenario, panel: CoupledPanel) -> list[Softened]:
        """Return Young's modulus of the contacts of each patch [Pa], and its bias of g rms [1]."""
        stated, frequency = (
            self.study.damping.coupled.youngs_modulus_mpa,
            self.coarse_frequency,
        )
        omega = 2 * np.pi * frequency
        moduli = []
        for (_, coupon, _), bed, patch in zip(
            coupled.fillings, coupled.beds[0], panel.patches, strict=True
        ):
            psd = panel.bare_psd(patch.shape, frequency) @ patch.area / patch.area.sum()
            squares = [float(np.trapezoid(omega**k * psd, frequency)) for k in (2, 4)]
            motion, own = RmsMotion(*np.sqrt(squares)), coupon.particles.youngs_modulus
            modulus = stated * 1e6 if stated else softened_modulus(own, bed, motion)
            moduli.append(Softened(modulus, softening_bias(own, bed, motion, modulus)))
        return moduli


# ------------------------------------------------------------------------------- one run


@dataclass(frozen=True)
class DrawnRun:
    """A run that is ready to be integrated.

    Attributes
    ----------
    integration, start
        The panel with its forces; q [m] and q̇ [m/s], (2, n).
    frequency, amplitude, first
        Of its sound, as in `SettledRecord`.
    """

    integration: Integration
    start: Array
    beds: Sequence[StartedBed]
    frequency: Array
    amplitude: Complexes
    first: int


@dataclass(frozen=True)
class ScenarioRuns:
    """The runs of a scenario, each with a sound and beds of its own.

    Attributes
    ----------
    store
        Folder of packings and beds; those that are missing are made.
    folder
        Of the records, which are kept.
    """

    studied: ExcitedPanel
    coupled: CoupledScenario
    store: Path
    folder: Path

    @cached_property
    def panel(self) -> CoupledPanel:
        """The panel with its patches."""
        return self.studied.in_sound(self.coupled)

    @cached_property
    def softened(self) -> list[Softened]:
        """Young's modulus of the contacts of each patch, and its bias."""
        return self.studied.moduli(self.coupled, self.panel)

    @property
    def bias(self) -> float:
        """Largest bias of g rms by softened contacts [1]."""
        return max(one.bias for one in self.softened)

    def drawn(self, number: int) -> DrawnRun:
        """Draw the sound of a run and start its beds."""
        study, panel = self.studied.study, self.panel
        low, high = study.response.frequency_hz
        keys, period = study.damping.coupled, study.damping.coupled.duration_s
        rows = int(np.ceil(ROWS_PER_PERIOD * high * period))
        interval = period / rows
        settled = round(keys.settle_s / interval)
        beds = list(zip(self.coupled.beds[number - 1], self.softened, strict=True))
        longest = STEP_RAYLEIGH * min(rayleigh_time_of(bed, soft.modulus) for bed, soft in beds)
        intervals, substeps = _steps(interval, longest, 1 / (INTERVALS_PER_PERIOD * high))
        first = int(np.ceil(low * period))
        frequency = np.arange(first, int(high * period) + 1) / period
        amplitude = sound_record.draw_modal_force(
            frequency,
            panel.spectrum(frequency),
            panel.modal_force,
            sound_record.force_nodes(low, high, study.sound.speed_m_s, self.studied.diameter),
            np.random.default_rng([number, *self.coupled.name.encode()]),
        )
        held = amplitude * sound_record.before_hold(frequency, interval)[:, None]
        force = sound_record.samples(held, first, rows)
        # what counts is a period, before it comes the end of the one before
        force = force[np.arange(-settled, rows + 1) % rows]
        turned = np.exp(-2j * np.pi * frequency * settled * interval)
        bare = amplitude * turned[:, None] / panel.stiffness(frequency)
        modal = panel.modal
        shapes = PanelShapes(
            modal.angular_frequency,
            modal.damping_ratio,
            modal.modal_mass,
            panel.at_cells,
            panel.points,
        )
        return DrawnRun(
            Integration(
                shapes,
                panel.area,
                np.concatenate([np.full(len(one.area), one.cell_area) for one in panel.patches]),
                force,
                interval / (intervals * substeps),
                substeps,
                intervals,
                settled,
            ),
            np.stack([bare.real.sum(axis=0), (2j * np.pi * frequency @ bare).real]),
            [
                started(bed, soft.modulus, self.store / "bed" / bed.label / BED_JSON)
                for bed, soft in beds
            ],
            frequency,
            amplitude,
            first,
        )

    def masses(self, number: int) -> Array:
        """Return what the beds of a run weigh [kg/m²]."""
        beds = self.coupled.beds[number - 1]
        return np.array([mass_per_area(bed, self.store / "bed" / bed.label) for bed in beds])

    def record(self, number: int) -> SettledRecord:
        """Return the record of a run: the stored one, or that of its integration.

        A run that was stopped resumes from its checkpoint, to the same bits.

        Raises
        ------
        SolverFailure
            If a bed failed, LIGGGHTS stops or hangs, or the energy does not balance.
        """
        run, name = self.drawn(number), f"{self.coupled.name}, run {number}"
        path = self.folder / f"run{number}.nc"
        identity = run_identity(run.integration, run.start, run.beds)
        stored = read_record(path, identity)
        if stored is not None:
            return stored
        checkpoints = path.with_suffix("")
        record = integrated(name, run.integration, run.start, run.beds, checkpoints)
        error = record.balance.error
        if not abs(error) <= BALANCE_LIMIT:
            raise EnergyNotClosed(
                f"{name}: {100 * error:.2g} % of the sound's energy is missing; allowed is "
                f"{100 * BALANCE_LIMIT:g} %"
            )
        write_record(
            path,
            SettledRecord(
                run.frequency,
                run.amplitude,
                run.first,
                run.integration.rows,
                run.integration.settled,
                record.interval,
                record.at_cells,
                record.at_points,
                record.impulse,
            ),
            {
                **stamp(self.studied.study),
                IDENTITY: identity,
                "balance_error": error,
                "share_of_particles": record.balance.particles / record.balance.sound,
                "youngs_modulus_pa": [float(soft.modulus) for soft in self.softened],
                "time_step_s": run.integration.time_step,
                "mass_per_area_kg_m2": self.masses(number).tolist(),
            },
        )
        durable.discard(checkpoints)
        stored = read_record(path, identity)  # rounded as it is stored
        if stored is None:
            raise FilesFailed(f"{path}: cannot be read after it was written")
        return stored

    def estimate(self, records: Sequence[SettledRecord]) -> ScenarioEstimate:
        """Return what some records tell."""
        centre, edge = whole_third_octaves(*self.studied.study.response.frequency_hz)
        frequency = self.studied.coarse_frequency
        return estimate(self.panel, records, frequency, centre, edge, self.bias)


def _steps(row: float, longest_step: float, longest_interval: float) -> tuple[int, int]:
    """Return the even number of intervals in a row, and the steps in an interval.

    Examples
    --------
    >>> _steps(50e-6, 1.3e-6, 8e-6), _steps(50e-6, 10e-6, 8e-6)
    ((8, 5), (8, 1))
    """
    steps = max(1, int(longest_interval / longest_step))
    intervals = 2 * int(np.ceil(row / min(longest_interval, steps * longest_step) / 2))
    return intervals, int(np.ceil(row / intervals / longest_step))


# ---------------------------------------------------------------------------- one scenario


def write_scenario(
    study: Study,
    files: CoupledFiles,
    label: str,
    store: Path,
    folder: Path,
    output: Path,
) -> None:
    """Integrate runs of a scenario until its rms accelerations are known, and write the estimate.

    Parameters
    ----------
    study, files
        The study, and files of the stages upstream.
    label
        One of `coupled_scenarios`.
    store, folder
        As of `ScenarioRuns`.
    output
        The ``.nc`` file.

    Raises
    ------
    SolverFailure
        As of `ScenarioRuns.record`.
    """
    coupled, keys = coupled_scenarios(study)[label], study.damping.coupled
    runs = ScenarioRuns(ExcitedPanel.read(study, files), coupled, store, folder)
    folder.mkdir(parents=True, exist_ok=True)
    records: list[SettledRecord] = []
    for number in range(1, keys.runs + 1):
        records.append(runs.record(number))
        found = runs.estimate(records)
        # further runs do not reduce the bias
        error = np.sqrt(np.maximum((found.log_error / 2) ** 2 - runs.bias**2, 0))
        if error.max() <= keys.relative_error:
            break
    masses = np.mean([runs.masses(number + 1) for number in range(len(records))], axis=0)
    beds = [
        estimate_files.SimulatedBed(
            filling.patch, bed.packing.cell_area, float(mass), float(soft.modulus)
        )
        for (filling, *_), bed, mass, soft in zip(
            coupled.fillings, coupled.beds[0], masses, runs.softened, strict=True
        )
    ]
    points = runs.studied.basis.point_names
    estimate_files.write_estimate(output, found, beds, points, len(records), stamp(study))


def estimated_cpu_seconds(study: Study) -> float:
    """Return about the CPU time of the coupled runs of a study [s].

    With one run of each scenario and the modulus of a usual motion.
    """
    keys, seconds = study.damping.coupled, 0.0
    high = study.response.frequency_hz[1]
    for coupled in coupled_scenarios(study).values():
        spheres, steps = [], []
        for (_, coupon, fill), bed in zip(coupled.fillings, coupled.beds[0], strict=True):
            packing = bed.packing
            modulus = usual_modulus(coupon.particles.youngs_modulus, packing.density)
            if keys.youngs_modulus_mpa is not None:
                modulus = 1e6 * keys.youngs_modulus_mpa
            steps.append(STEP_RAYLEIGH * rayleigh_time_of(bed, modulus))
            spheres.append(round(spheres_in(packing, fill)))
        interval = 1 / (INTERVALS_PER_PERIOD * high)
        substeps = max(1, int(interval / min(steps)))
        cost = sum(cpu_per_interval(count, substeps) for count in spheres)
        seconds += keys.run_s / (substeps * min(steps)) * cost
    return seconds


# ------------------------------------------------------------------------- all of a study


def write_coupled(
    study: Study, files: CoupledFiles, estimates: Sequence[Path], outputs: CoupledTables
) -> None:
    """Write the tables of all scenarios.

    Parameters
    ----------
    study, files
        The study, and files of the stages upstream.
    estimates
        Of `coupled_scenarios`, in order.
    """
    studied = ExcitedPanel.read(study, files)
    found = [
        (coupled, estimate_files.read_estimate(path))
        for coupled, path in zip(coupled_scenarios(study).values(), estimates, strict=True)
    ]
    frames = [estimate_files.frames(coupled.name, stored) for coupled, stored in found]
    impedances = [
        (coupled.scenario, frame.impedance)
        for (coupled, _), frame in zip(found, frames, strict=True)
    ]
    tables_of = (
        (outputs.summary, [frame.summary for frame in frames]),
        (outputs.third_octaves, [frame.third_octaves for frame in frames]),
        (outputs.psd, [frame.psd for frame in frames]),
        (
            outputs.impedance,
            [table for _, table in impedances] + _carried(studied, impedances),
        ),
    )
    for path, parts in tables_of:
        pd.concat(parts).to_csv(path, index=False, float_format="%.6g")


def _carried(
    studied: ExcitedPanel, of_level: Sequence[tuple[Scenario, pd.DataFrame]]
) -> list[pd.DataFrame]:
    """Return C_e, m_a and own force of the scenarios that were not run, from other levels."""

    def level(scenario: Scenario) -> float:
        return scenario.oaspl_db or studied.excitation.bands.oaspl

    carried_tables, run = [], {scenario.label for scenario, _ in of_level}
    for scenario in studied.study.coupled_scenarios():
        if scenario.label in run:
            continue
        alike = [pair for pair in of_level if pair[0].fillings == scenario.fillings]
        levels = [level(other) for other, _ in alike]
        near = [alike[k] for k in carried.nearest(level(scenario), levels, NEIGHBOURS_DB)]
        places = [(level(other), table) for other, table in near]
        source = " and ".join(other.label for other, _ in near)
        carried_tables.append(
            tables.carried_impedances(scenario.label, source, level(scenario), places)
        )
    return carried_tables
