"""The coupled runs of a study, and what is found in them: the only module here that knows it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pandas as pd

from pidpanel import durable
from pidpanel.arrays import Array
from pidpanel.coupled import carried, linear, sound_record, tables
from pidpanel.coupled.beds import cpu_per_step, mass_per_area, rayleigh_time_of
from pidpanel.coupled.integration import Integration, PanelShapes
from pidpanel.coupled.pieces import integrated, started
from pidpanel.coupled.record_files import read_masses, read_record, write_record
from pidpanel.coupled.results import (
    CoupledPanel,
    CoupledPatch,
    CoupledResult,
    SettledRecord,
    coupled_result,
)
from pidpanel.coupled.stations import stations_of
from pidpanel.coupon import contact
from pidpanel.coupon.cases import Bed
from pidpanel.coupon.drive import Tone
from pidpanel.coupon.from_study import bed_of
from pidpanel.coupon.liggghts.failures import EnergyNotClosed
from pidpanel.panel.plate_files import StoredPlate, read_plate
from pidpanel.response.bands import whole_third_octaves
from pidpanel.response.basis_error import joined_shapes
from pidpanel.response.from_study import PanelFiles, PanelInSound, read_panel_in_sound
from pidpanel.response.lines import root_mean_square
from pidpanel.stamp import stamp
from pidpanel.study import Scenario, Study
from pidpanel.study.coupon import Coupon
from pidpanel.study.damping import NEIGHBOURS_DB

ROWS_PER_PERIOD = 10.0
"""Rows of a record in a period of the highest frequency: what is joined linearly between them is
3 % low there, for which the sound is corrected."""

BALANCE_LIMIT = 0.01
"""Largest share of the sound's energy that may be missing in a run [1]."""

FASTEST = 3.0
"""Speed of the impacts by which the modulus is chosen, over the rms speed of the bare patch."""

BULK_FRACTION = 0.45
"""Of a full cell, for an estimate [1]."""


@dataclass(frozen=True)
class CoupledRun:
    """One scenario under one record of its sound.

    Attributes
    ----------
    scenario
        Which.
    seed
        Of the sound and the packings.
    beds
        Of its filled patches.
    """

    scenario: Scenario
    seed: int
    beds: tuple[Bed, ...]

    @property
    def name(self) -> str:
        """Folder and file below ``results/<study>/coupled``, without its ending."""
        return f"{self.scenario.label}/seed{self.seed}"


def coupled_runs(study: Study) -> dict[str, CoupledRun]:
    """Return the runs of a study by their names."""
    if not study.is_coupled:
        return {}
    keys = study.damping.coupled
    runs = [
        CoupledRun(
            scenario,
            seed,
            tuple(
                bed_of(coupon, fill, cells=keys.cells, seed=seed)
                for coupon, fill in _fillings(study, scenario)
            ),
        )
        for scenario in study.all_scenarios()
        if not scenario.is_bare and scenario.label in (keys.scenarios or [scenario.label])
        for seed in range(1, keys.seeds + 1)
    ]
    return {run.name: run for run in runs}


def _fillings(study: Study, scenario: Scenario) -> list[tuple[Coupon, float]]:
    """Return coupon and fill of each filled patch; the study refuses those without."""
    found = []
    for filling in scenario.fillings:
        coupon = study.all_dampers[str(filling.damper)].coupon
        if coupon is not None and filling.fill_fraction is not None:
            found.append((coupon, filling.fill_fraction))
    return found


class CoupledFiles(NamedTuple):
    """Files of the stages upstream."""

    modes: Path
    modal_force: Path
    plate: Path


@dataclass(frozen=True)
class StudiedPanel:
    """The panel of a study in its sound, with stations on its patches.

    Attributes
    ----------
    study
        The study.
    panel
        In its sound.
    plate
        Its elements.
    """

    study: Study
    panel: PanelInSound
    plate: StoredPlate

    @staticmethod
    def read(study: Study, files: CoupledFiles) -> StudiedPanel:
        """Read what the stages upstream left."""
        upstream = PanelFiles(files.modes, files.modal_force, None)
        return StudiedPanel(
            study, read_panel_in_sound(study, upstream, "none"), read_plate(files.plate)
        )

    @cached_property
    def points(self) -> Array:
        """(p, n) the shapes at the points."""
        return self.panel.deflection_at_points[:, 0]

    @property
    def diameter(self) -> float:
        """Of the panel [m]."""
        return float(np.hypot(*np.ptp(self.panel.basis.vertex_position, axis=0)))

    @cached_property
    def _vectors(self) -> Array:
        nothing = np.zeros((len(self.plate.shapes), 0))
        return joined_shapes(self.panel.basis, self.plate, nothing).vectors

    def patch(self, name: str, cell_area: float) -> CoupledPatch:
        """Return a patch with its stations.

        Parameters
        ----------
        name
            Of the patch.
        cell_area
            Of one cell [m²].
        """
        basis, keys = self.panel.basis, self.study.damping.coupled
        index = basis.patch_names.index(name)
        per_cell = len(self.plate.quadrature_weight) // len(basis.cells)
        cells = np.flatnonzero(basis.cell_in_patch[index])
        rows = (cells[:, None] * per_cell + np.arange(per_cell)).ravel()
        found = stations_of(
            self.plate.quadrature_position[rows],
            self.plate.quadrature_weight[rows],
            keys.stations,
        )
        shape = np.asarray(self.plate.at_quadrature[rows[found.point]] @ self._vectors)
        return CoupledPatch(
            shape, found.area, keys.cells // keys.stations * cell_area, basis.patch_overlap[index]
        )

    def in_sound(self, run: CoupledRun) -> CoupledPanel:
        """Return the panel with the patches of a run, at the level of its scenario."""
        factor = self.panel.pressure_factor(run.scenario)
        return CoupledPanel(
            stiffness=self.panel.modal.dynamic_stiffness,
            points=self.points,
            patches=[
                self.patch(filling.patch, bed.packing.cell_area)
                for filling, bed in zip(run.scenario.fillings, run.beds, strict=True)
            ],
            pressure_psd=lambda frequency: factor * self.panel.psd(frequency),
            modal_force=self.panel.force,
        )

    def moduli(self, run: CoupledRun, coupled: CoupledPanel) -> list[float]:
        """Return Young's modulus of the contacts of each patch [Pa]."""
        keys, frequency = self.study.damping.coupled, self.panel.coarse_frequency
        if keys.youngs_modulus_mpa is not None:
            return [keys.youngs_modulus_mpa * 1e6 for _ in run.beds]
        omega = 2 * np.pi * frequency[:, None]
        found = []
        fillings = _fillings(self.study, run.scenario)
        for (coupon, _), bed, patch in zip(fillings, run.beds, coupled.patches, strict=True):
            psd = _bare_psd(coupled, patch.shape, frequency) @ patch.area / patch.area.sum()
            squares = [np.trapezoid(omega[:, 0] ** k * psd, frequency) for k in (2, 4)]
            speed, acceleration = np.sqrt(squares)
            found.append(modulus_for(coupon, bed, speed, acceleration))
        return found


def modulus_for(coupon: Coupon, bed: Bed, speed: float, acceleration: float) -> float:
    """Return the softest modulus [Pa] whose contacts are short and shallow, as of a tone's run.

    Softened contacts stay so at low levels, where a tone has the material's own: at 122 dB g rms
    is that of the coupon driven at random with its own (docs/theory.md).

    Parameters
    ----------
    coupon, bed
        The damper, and one of its beds.
    speed, acceleration
        Rms speed [m/s] and acceleration [m/s²] of the bare patch. Impacts are `FASTEST` times as
        fast as that; W/L is that of the sine with this rms acceleration at their ratio.
    """
    tone = Tone(acceleration / (2 * np.pi * speed), np.sqrt(2) * acceleration)
    longest, deepest = coupon.stiffness.limits(bed.stroke_per_gap(tone))
    return contact.softest_modulus(
        coupon.stiffness.choices,
        coupon.particles.youngs_modulus,
        radius=bed.packing.sizes.largest / 2,
        density=bed.packing.density,
        poissons_ratio=coupon.particles.poissons_ratio,
        speed=FASTEST * speed,
        frequency=tone.frequency,
        contact_time_per_period=longest,
        overlap_per_radius=deepest,
    )


def _bare_psd(coupled: CoupledPanel, seen: Array, frequency: Array) -> Array:
    """Return the PSDs (nf, s) of motions of the bare panel [m²/Hz]."""
    n = seen.shape[1]
    nothing = np.zeros((1, n, n))
    (found,) = linear.point_psds(
        frequency,
        coupled.stiffness(frequency),
        np.zeros((n, 1)),
        [np.zeros((len(frequency), 1, 1), complex)],
        seen,
        coupled.pressure_psd(frequency),
        coupled.modal_force,
        [lambda _: nothing],
    )
    return found


# ------------------------------------------------------------------------------- one run


def write_run(
    study: Study,
    files: CoupledFiles,
    name: str,
    bed_files: Sequence[Path],
    folder: Path,
    output: Path,
) -> None:
    """Integrate panel and particles of a run and write the record.

    A run that was stopped goes on from its last checkpoint, to the same bits.

    Parameters
    ----------
    study, files
        The study, and files of the stages upstream.
    name
        One of `coupled_runs`.
    bed_files
        ``bed.json`` of each filled patch.
    folder
        For its checkpoints, removed at the end.
    output
        The ``.nc`` file.

    Raises
    ------
    SolverFailure
        If a bed failed, LIGGGHTS stops or hangs, or the energy does not balance.
    """
    run, studied = coupled_runs(study)[name], StudiedPanel.read(study, files)
    coupled = studied.in_sound(run)
    moduli = studied.moduli(run, coupled)
    time_step = min(
        coupon.time_step_rayleigh * rayleigh_time_of(bed, modulus)
        for (coupon, _), bed, modulus in zip(
            _fillings(study, run.scenario), run.beds, moduli, strict=True
        )
    )
    low, high = study.response.frequency_hz
    steps_per_row = 2 * max(1, int(0.5 / (ROWS_PER_PERIOD * high * time_step)))
    interval = steps_per_row * time_step
    keys = study.damping.coupled
    settled, rows = (
        round(duration / interval) for duration in (keys.settle_s, keys.settle_s + keys.duration_s)
    )
    first = int(np.ceil(low * rows * interval))
    frequency = np.arange(first, int(high * rows * interval) + 1) / (rows * interval)
    amplitude = sound_record.draw_modal_force(
        frequency,
        coupled.pressure_psd(frequency),
        coupled.modal_force,
        sound_record.force_nodes(low, high, study.sound.speed_m_s, studied.diameter),
        np.random.default_rng([run.seed, *run.scenario.label.encode()]),
    )
    held = amplitude * sound_record.before_hold(frequency, interval)[:, None]
    force = sound_record.samples(held, first, rows)
    bare = amplitude / coupled.stiffness(frequency)
    start = np.stack([bare.real.sum(axis=0), (2j * np.pi * frequency @ bare).real])
    modal = studied.panel.modal
    shapes = PanelShapes(
        modal.angular_frequency,
        modal.damping_ratio,
        modal.modal_mass,
        coupled.at_stations,
        coupled.points,
    )
    integration = Integration(
        shapes,
        coupled.area,
        np.concatenate([np.full(len(p.area), p.cell_area) for p in coupled.patches]),
        np.concatenate([force, force[:1]]),
        time_step,
        steps_per_row,
        settled,
    )
    beds = [
        started(bed, modulus, file)
        for bed, modulus, file in zip(run.beds, moduli, bed_files, strict=True)
    ]
    record = integrated(name, integration, start, beds, keys.stations, folder)
    error = record.balance.error
    if not abs(error) <= BALANCE_LIMIT:
        raise EnergyNotClosed(
            f"{name}: {100 * error:.2g} % of the sound's energy is missing; allowed is "
            f"{100 * BALANCE_LIMIT:g} %"
        )
    write_record(
        output,
        SettledRecord(
            frequency,
            amplitude,
            first,
            rows,
            settled,
            interval,
            record.at_stations,
            record.at_points,
            record.impulse,
        ),
        {
            **stamp(study),
            "balance_error": error,
            "share_of_particles": record.balance.particles / record.balance.sound,
            "youngs_modulus_pa": " ".join(f"{modulus:g}" for modulus in moduli),
            "time_step_s": time_step,
            "mass_per_area_kg_m2": [mass_per_area(one.bed, one.folder) for one in beds],
        },
    )
    durable.discard(folder)


def estimated_cpu_seconds(study: Study) -> float:
    """Return about the least CPU time of the runs of a study [s].

    With the softest contacts that the study allows; how soft they may be the panel's motion says.
    """
    keys, seconds = study.damping.coupled, 0.0
    for run in coupled_runs(study).values():
        spheres, steps = 0.0, []
        for (coupon, fill), bed in zip(_fillings(study, run.scenario), run.beds, strict=True):
            packing = bed.packing
            softest = min(*coupon.stiffness.choices, coupon.particles.youngs_modulus)
            modulus = 1e6 * (keys.youngs_modulus_mpa or softest / 1e6)
            steps.append(coupon.time_step_rayleigh * rayleigh_time_of(bed, modulus))
            volume = BULK_FRACTION * packing.area * packing.depth
            spheres += fill * volume / (np.pi / 6 * packing.diameter**3)
        duration = keys.settle_s + keys.duration_s
        seconds += duration / min(steps) * cpu_per_step(round(spheres))
    return seconds


# ------------------------------------------------------------------------- all of a study


def write_coupled(
    study: Study,
    files: CoupledFiles,
    records: Sequence[Path],
    summary_csv: Path,
    bands_csv: Path,
    impedance_csv: Path,
    psd_csv: Path,
) -> None:
    """Write what the records of all runs tell.

    Parameters
    ----------
    study, files
        The study, and files of the stages upstream.
    records
        Of all runs, in the order of `coupled_runs`.
    summary_csv, bands_csv, impedance_csv, psd_csv
        Rms values by scenario and point; third octaves; C_e, m_a and own force; PSDs.
    """
    studied = StudiedPanel.read(study, files)
    paths = dict(zip(coupled_runs(study).values(), records, strict=True))
    found: list[tuple[pd.DataFrame, ...]] = []
    of_level: list[tuple[Scenario, pd.DataFrame]] = []
    frequency = studied.panel.frequency
    keys = study.damping.coupled
    for label in dict.fromkeys(run.scenario.label for run in paths):
        runs = [run for run in paths if run.scenario.label == label]
        coupled = studied.in_sound(runs[0])
        result = _result_of(studied, coupled, [read_record(paths[run]) for run in runs])
        masses = np.mean([read_masses(paths[run]) for run in runs], axis=0)
        bare = root_mean_square(
            frequency,
            (2 * np.pi * frequency[:, None]) ** 4 * _bare_psd(coupled, coupled.points, frequency),
        )
        points = studied.panel.basis.point_names
        beds = _beds_of(runs[0], keys.stations, masses)
        of_level.append((runs[0].scenario, tables.impedances(label, beds, result)))
        found.append(
            (
                tables.summary(label, points, bare, result),
                tables.third_octaves(label, points, result),
                tables.psds(label, points, frequency, result),
            )
        )
    for path, *parts in zip((summary_csv, bands_csv, psd_csv), *found, strict=True):
        pd.concat(parts).to_csv(path, index=False, float_format="%.6g")
    impedances = [table for _, table in of_level] + _carried(studied, of_level)
    pd.concat(impedances).to_csv(impedance_csv, index=False, float_format="%.6g")


def _carried(
    studied: StudiedPanel, of_level: Sequence[tuple[Scenario, pd.DataFrame]]
) -> list[pd.DataFrame]:
    """Return C_e, m_a and own force of the scenarios that were not run, from other levels."""

    def level(scenario: Scenario) -> float:
        return scenario.oaspl_db or studied.panel.spectrum.oaspl

    found, run = [], {scenario.label for scenario, _ in of_level}
    for scenario in studied.study.all_scenarios():
        if scenario.is_bare or scenario.label in run:
            continue
        alike = [one for one in of_level if one[0].fillings == scenario.fillings]
        levels = [level(one) for one, _ in alike]
        near = [alike[k] for k in carried.nearest(level(scenario), levels, NEIGHBOURS_DB)]
        places = [(level(one), table) for one, table in near]
        source = " and ".join(one.label for one, _ in near)
        found.append(tables.carried_impedances(scenario.label, source, level(scenario), places))
    return found


def _beds_of(run: CoupledRun, stations: int, masses: Array) -> list[tables.SimulatedBed]:
    """Return what was simulated on each patch of a run."""
    return [
        tables.SimulatedBed(
            patch, bed.packing.cell_area, bed.packing.count // stations, float(mass)
        )
        for patch, bed, mass in zip(run.scenario.patches, run.beds, masses, strict=True)
    ]


def _result_of(
    studied: StudiedPanel, coupled: CoupledPanel, records: Sequence[SettledRecord]
) -> CoupledResult:
    low, high = studied.study.response.frequency_hz
    centre, edge = whole_third_octaves(low, high)
    return coupled_result(coupled, records, studied.panel.frequency, centre, edge)
