"""A record in segments, and a linear panel under the same excitation."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.coupled.coupled_panel import CoupledPanel, Impedance, cell_load
from pidpanel.coupled.force_record import samples
from pidpanel.coupled.impedance import ImpedanceSums
from pidpanel.coupled.linear import linear_motion
from pidpanel.coupled.own_force import own_force_sums
from pidpanel.coupled.spectra import band_sums, pressure_segments, segment_spectra

# Length of a segment [s], or half a record that is shorter than two: 2 Hz resolve a resonance of
# 65 Hz with ζ = 3 %.
SEGMENT_S = 0.5

# Fewest periods of the lowest frequency in a segment: its third octave then holds a line.
PERIODS = 5.0


@dataclass(frozen=True)
class SettledRecord:
    """A record with its modal forces."""

    # (nf,) of the tones [Hz] and (nf, n) their modal forces [N]
    frequency: Array
    amplitude: Complexes
    # Number of the first tone in periods of the forces, rows of the record, and the first row that
    # is used: from there the forces have one period
    first: int
    rows: int
    settled: int
    interval: float  # time between rows [s]
    # (m, c) and (m, p) displacement [m]
    at_cells: Array
    at_points: Array
    # (m, c) impulse of the walls on the particles since the start, per area of a cell [N s/m²]
    impulse: Array

    @property
    def segment(self) -> int:
        """Rows of a segment."""
        length = max(SEGMENT_S, PERIODS / self.frequency[0])
        return min(round(length / self.interval), (self.rows - self.settled - 1) // 2)


class RecordSegments:
    """Spectra of the segments of one record, and of a linear panel under the same forces."""

    def __init__(self, panel: CoupledPanel, record: SettledRecord, band: tuple[float, float]):
        self._panel, self._record = panel, record
        self._cells = len(panel.at_cells)
        rows = np.concatenate([record.at_cells, record.at_points], axis=1)
        self._segmentation = record.interval, record.segment, band
        settled = rows[record.settled : -1], record.impulse[record.settled :]
        self.frequency, self.recorded = segment_spectra(settled[0], *self._segmentation)
        self.pressure = pressure_segments(settled[1], *self._segmentation)
        self.resolution = float(self.frequency[1] - self.frequency[0])
        self.count = len(self.recorded)
        self._omega = 2j * np.pi * self.frequency[:, None]
        self.velocity = self._omega * self.recorded[:, :, : self._cells]

    def linear_motion(self, impedances: Sequence[Impedance]) -> Complexes:
        """Return the spectra of the motion of cells and points with linear dampers."""
        record, panel = self._record, self._panel
        observed = np.concatenate([panel.at_cells, panel.points])
        load = cell_load(panel, record.frequency, impedances)
        cells = panel.at_cells.T
        amplitude = linear_motion(
            record.frequency, panel.modal, panel.added, cells, observed, load, record.amplitude
        )
        settled = samples(amplitude, record.first, record.rows - record.settled)
        return segment_spectra(settled[:-1], *self._segmentation)[1]

    def impedance_sums(self, motion: Complexes, patch: int, edge: Array) -> ImpedanceSums:
        """Return the cross-spectra of a patch with a linear motion as instrument."""
        part = self._panel.slices[patch]
        pressure, velocity = self.pressure[:, :, part], self.velocity[:, :, part]
        instrument, area = self._omega * motion[:, :, part], self._panel.area[part]
        return ImpedanceSums.from_spectra(
            self.frequency, pressure, velocity, instrument, area, edge
        )

    def own_force(self, impedance: Impedance, patch: int, edge: Array) -> Array:
        """Return the cross-spectra of the own forces of the cells of a patch."""
        part = self._panel.slices[patch]
        linear_part = impedance(self.frequency)[:, None] * self.velocity[:, :, part]
        return own_force_sums(self.frequency, self.pressure[:, :, part] - linear_part, edge)

    def velocity_squares(self) -> Array:
        """Return the mean squares of the velocity of each patch, (segments, patches) [m²/s²]."""
        by_cell = (np.abs(self.velocity) ** 2).sum(axis=1) * self.resolution
        area = self._panel.area
        parts = self._panel.slices
        return np.stack([by_cell[:, s] @ area[s] / area[s].sum() for s in parts], axis=1)

    def squares(self, motion: Complexes, edge: Array) -> Array:
        """Return the mean squares of accelerations at the points, (segments, bands, p)."""
        values = motion[:, :, self._cells :]
        psd = np.abs(self._omega**2 * values) ** 2
        return band_sums(self.frequency, psd, edge, axis=1) * self.resolution

    def lines(self, edge: Array) -> Index:
        """Return the number of lines of each band."""
        return np.diff(np.searchsorted(self.frequency, edge), axis=1)[:, 0]
