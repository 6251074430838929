"""The runs of a scenario: drawn, integrated and recorded."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import cast

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.coupled import force_record
from pidpanel.coupled.beds import StartedBed, mass_per_area, started
from pidpanel.coupled.checkpoints import IDENTITY, read_record, write_record
from pidpanel.coupled.coupled_panel import CoupledPanel
from pidpanel.coupled.estimate import ScenarioEstimate, estimate
from pidpanel.coupled.excited_panel import ExcitedPanel
from pidpanel.coupled.integration import Integration, drift_free_velocity
from pidpanel.coupled.pieces import integrated, run_identity
from pidpanel.coupled.scenario import CoupledScenario
from pidpanel.coupled.segments import SettledRecord
from pidpanel.coupled.softening import Softened
from pidpanel.coupon.liggghts.failures import EnergyNotClosed
from pidpanel.provenance import durable
from pidpanel.solve.bands import whole_third_octaves
from pidpanel.solve.base_motion import BaseExcitation

# Rows of a record in a period of the highest frequency: what is linear between them is 3 % low
# there, for which the modal forces are corrected.
ROWS_PER_PERIOD = 10.0

# Fewest intervals of the integration in a period of the highest frequency.
INTERVALS_PER_PERIOD = 60.0

# Time step over the Rayleigh time of the smallest sphere [1]: 0.1, 0.2 and 0.4 give the same
# g rms within their scatter (benchmarks/coupled.md).
STEP_RAYLEIGH = 0.4

FREE = 1e-3  # natural frequency over the lowest of the run below which a shape is not held [1]

BALANCE_LIMIT = 0.01  # largest share of the energy put in that may be missing in a run [1]


@dataclass(frozen=True)
class DrawnRun:
    """A run that is ready to be integrated."""

    # The panel with its forces; q [m] and q̇ [m/s], (2, n)
    integration: Integration
    start: Array
    beds: Sequence[StartedBed]
    # Tones of its modal forces; see `SettledRecord`
    frequency: Array
    amplitude: Complexes
    first: int


@dataclass(frozen=True)
class ScenarioRuns:
    """The runs of a scenario, each with modal forces and beds of its own."""

    excited: ExcitedPanel
    scenario: CoupledScenario
    store: Path  # folder of packings and beds; those that are missing are made
    folder: Path  # of the records, which are kept

    @cached_property
    def panel(self) -> CoupledPanel:
        """The panel with its patches."""
        return self.excited.with_patches(self.scenario)

    @cached_property
    def softened(self) -> list[Softened]:
        """Contacts of each patch."""
        return self.excited.moduli(self.scenario, self.panel)

    def drawn(self, number: int) -> DrawnRun:
        """Draw the modal forces of a run and start its beds."""
        settings, panel = self.excited.settings, self.panel
        (low, high), period = settings.frequency_range, settings.duration
        rows = int(np.ceil(ROWS_PER_PERIOD * high * period))
        interval = period / rows
        settled = round(settings.settling / interval)
        beds = list(zip(self.scenario.beds[number - 1], self.softened, strict=True))
        longest = STEP_RAYLEIGH * min(
            bed.packing.smallest(soft.modulus).rayleigh_time for bed, soft in beds
        )
        intervals, substeps = _steps(interval, longest, 1 / (INTERVALS_PER_PERIOD * high))
        first = int(np.ceil(low * period))
        frequency = np.arange(first, int(high * period) + 1) / period
        nodes = force_record.force_nodes(low, high, settings.wave_speed, self.excited.diameter)
        rng = np.random.default_rng([number, *self.scenario.name.encode()])
        amplitude = force_record.draw_modal_force(frequency, panel.excitation, nodes, rng)
        joined = amplitude * force_record.before_hold(frequency, interval)[:, None]
        force = force_record.samples(joined, first, rows)
        # one period is used; it is preceded by the end of the one before
        force = force[np.arange(-settled, rows + 1) % rows]
        turned = np.exp(-2j * np.pi * frequency * settled * interval)
        bare = amplitude * turned[:, None] / panel.modal.dynamic_stiffness(frequency)
        modal = panel.modal
        integration = Integration(
            modal,
            panel.at_cells,
            panel.points,
            panel.area,
            np.concatenate([np.full(len(patch.area), patch.cell_area) for patch in panel.patches]),
            force,
            interval / (intervals * substeps),
            substeps,
            intervals,
            settled,
        )
        start = np.stack([bare.real.sum(axis=0), (2j * np.pi * frequency @ bare).real])
        if isinstance(self.excited.excitation, BaseExcitation):  # moves a table that nothing holds
            free = modal.natural_frequency < FREE * low
            period_force = integration.force[: rows + 1, free]
            start[1, free] = drift_free_velocity(
                period_force, modal.modal_mass[free], integration.interval, intervals
            )
        started_beds = [started(bed, soft.modulus, self._folder(bed.label)) for bed, soft in beds]
        return DrawnRun(integration, start, started_beds, frequency, amplitude, first)

    def _folder(self, bed: str) -> Path:
        return self.store / "bed" / bed

    def masses(self, number: int) -> Array:
        """Return what the beds of a run weigh [kg/m²]."""
        beds = self.scenario.beds[number - 1]
        return np.array([mass_per_area(bed, self._folder(bed.label)) for bed in beds])

    def record(self, number: int) -> SettledRecord:
        """Return the record of a run: the stored one, or that of its integration.

        A run that was stopped resumes from its checkpoint, to the same bits.
        """
        run, name = self.drawn(number), f"{self.scenario.name}, run {number}"
        integration = run.integration
        path = self.folder / f"run{number}.nc"
        identity = run_identity(integration, run.start, run.beds)
        stored = read_record(path, identity)
        if stored is not None:
            return stored
        checkpoints = path.with_suffix("")
        rows, balance = integrated(name, integration, run.start, run.beds, checkpoints)
        error = balance.error
        if not abs(error) <= BALANCE_LIMIT:
            raise EnergyNotClosed(
                f"{name}: {100 * error:.2g} % of the energy put in is missing; allowed is "
                f"{100 * BALANCE_LIMIT:g} %"
            )
        settled = SettledRecord(
            run.frequency, run.amplitude, run.first, integration.rows, integration.settled,
            integration.row_interval, rows.at_cells, rows.at_points,
            rows.impulse / integration.cell_area,
        )  # fmt: skip
        attributes: dict[str, str | float | list[float]] = {
            **self.excited.settings.attributes,
            IDENTITY: identity,
            "balance_error": error,
            "share_of_particles": balance.particles / balance.excitation,
            "youngs_modulus_pa": [float(soft.modulus) for soft in self.softened],
            "time_step_s": integration.time_step,
            "mass_per_area_kg_m2": self.masses(number).tolist(),
        }
        write_record(path, settled, attributes)
        durable.discard(checkpoints)
        return cast(SettledRecord, read_record(path, identity))  # rounded as it is stored

    def estimate(self, records: Sequence[SettledRecord]) -> ScenarioEstimate:
        """Return the estimate from some records."""
        centre, edge = whole_third_octaves(*self.excited.settings.frequency_range)
        frequency = self.excited.coarse_frequency
        whole = self.excited.whole(self.scenario)
        return estimate(self.panel, records, frequency, centre, edge, self.softened, whole)


def _steps(row: float, longest_step: float, longest_interval: float) -> tuple[int, int]:
    """Return the (even) number of intervals in a row, and the steps in an interval.

    Examples
    --------
    >>> _steps(50e-6, 1.3e-6, 8e-6), _steps(50e-6, 10e-6, 8e-6)
    ((8, 5), (8, 1))
    """
    steps = max(1, int(longest_interval / longest_step))
    intervals = 2 * int(np.ceil(row / min(longest_interval, steps * longest_step) / 2))
    return intervals, int(np.ceil(row / intervals / longest_step))
