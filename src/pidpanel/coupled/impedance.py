"""C_e and m_a from records of the coupled run.

The sound is known, so the motion r that a linear panel has under it is known too, and it is
independent of the part n of the walls' force that is not linear in the motion. In a band

    Z = Σ a σ r* / Σ a v r*,    σ = Z v + n,    Z = C_e + iω m_a,

summed over lines, segments and cells: r is the instrument. The ratio of σ to v alone would include
the response of the panel to n. Z is the best linear approximation at the motion that the panel has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.coupled.spectra import band_sums

# Lines of Hann windows that overlap by half for one that is independent of the others [1]: the
# sum of the squared correlations of a line with all others in its segment, 1.94, and in the next
# ones.
LINES_PER_FREEDOM = 2.1

# Expected relative change of Z from one third octave to the next [1]: that of a mass grows by
# 26 %, that of an agitated bed is flat.
BAND_STEP = 0.3


@dataclass(frozen=True)
class ImpedanceSums:
    """Cross-spectra with the instrument, from which Z of a patch follows."""

    # (segments, cells, bands) Σ a σ r* and Σ a v r* over the lines of each band
    force: Complexes
    velocity: Complexes
    moment: Complexes  # (segments, bands) Σ f a v r* over lines and cells [Hz]
    # (segments, 2, 3, bands) Σ |x|², Σ |y|² and Σ x y* over lines, of the sums x and y of the
    # cells, and the sums of the same of each cell
    scatter: Complexes

    @staticmethod
    def from_spectra(
        frequency: Array,
        pressure: Complexes,
        velocity: Complexes,
        instrument: Complexes,
        area: Array,
        edge: Array,
    ) -> ImpedanceSums:
        """Return the sums of a record."""
        x, y = (values * instrument.conj() * area for values in (pressure, velocity))
        force, moved = (np.swapaxes(band_sums(frequency, v, edge, axis=1), 1, 2) for v in (x, y))

        def products(x: Complexes, y: Complexes) -> Complexes:
            parts: list[Array | Complexes] = [np.abs(x) ** 2, np.abs(y) ** 2, x * y.conj()]
            return np.stack([part.sum(axis=2) for part in parts], axis=1)

        summed = [values.sum(axis=2, keepdims=True) for values in (x, y)]
        scatter = np.stack([products(*summed), products(x, y)], axis=1)
        moment = band_sums(frequency, frequency * summed[1][:, :, 0], edge, axis=1)
        return ImpedanceSums(force, moved, moment, band_sums(frequency, scatter, edge, axis=3))

    @staticmethod
    def joined(parts: Sequence[ImpedanceSums]) -> ImpedanceSums:
        """Return the sums of several runs, with the cells of each run as cells of their own."""
        cells = [part.force.shape[1] for part in parts]
        ends = np.cumsum([0, *cells])

        def placed(values: Complexes, k: int) -> Complexes:
            wide = np.zeros((len(values), ends[-1], values.shape[2]), complex)
            wide[:, ends[k] : ends[k + 1]] = values
            return wide

        return ImpedanceSums(
            np.concatenate([placed(part.force, k) for k, part in enumerate(parts)]),
            np.concatenate([placed(part.velocity, k) for k, part in enumerate(parts)]),
            np.concatenate([part.moment for part in parts]),
            np.concatenate([part.scatter for part in parts]),
        )

    def impedance(self, cells: Array | None = None) -> BandImpedance:
        """Return Z of each band, with weights of the cells."""
        cells = np.ones(self.force.shape[1]) if cells is None else cells
        force, velocity = (np.einsum("scb,c->cb", v, cells) for v in (self.force, self.velocity))
        ratio = force.sum(axis=0) / velocity.sum(axis=0)
        of_x, of_y, product = np.einsum("sgkb->kgb", self.scatter)
        total = self.velocity.sum(axis=(0, 1))
        whole = self.force.sum(axis=(0, 1)) / total
        scatter = of_x.real - 2 * (whole.conj() * product).real + np.abs(whole) ** 2 * of_y.real
        variance, by_cell = LINES_PER_FREEDOM * np.maximum(scatter, 0.0) / np.abs(total) ** 2
        frequency = (self.moment.sum(axis=0) / total).real
        # what scatters from cell to cell is left to the jackknife over the cells
        value, covariance = smoothed(ratio, variance, np.maximum(variance - by_cell, 0.0))
        size, direction = np.linalg.eigh(covariance / 2)
        root = direction * np.sqrt(np.maximum(size, 0.0))
        return BandImpedance(frequency, value, np.concatenate([root, 1j * root], axis=1))


@dataclass(frozen=True)
class BandImpedance:
    """Z of a patch in bands; C_e and m_a are linear in ln f between them."""

    frequency: Array  # (bands,) rising, the mean of the motion in each band [Hz]
    value: Complexes  # (bands,) Z [N s/m³]
    # (bands, k) independent deviations of Z, one standard error each, by the chance of the own
    # force in the records [N s/m³]
    deviation: Complexes

    @property
    def apparent_mass(self) -> Array:
        """(bands,) m_a [kg/m²]."""
        return self.value.imag / (2 * np.pi * self.frequency)

    def __call__(self, frequency: Array) -> Complexes:
        """Return Z (nf,) at frequencies [Hz]."""
        lowest = self.frequency[0] / 2
        place, nodes = np.log(np.maximum(frequency, lowest)), np.log(self.frequency)
        damping = np.interp(place, nodes, self.value.real)
        mass = np.interp(place, nodes, self.apparent_mass)
        return damping + 2j * np.pi * frequency * mass

    def scaled(self, factor: float) -> BandImpedance:
        """Return the same with another C_e."""
        value, deviation = (factor * z.real + 1j * z.imag for z in (self.value, self.deviation))
        return BandImpedance(self.frequency, value, deviation)

    def deviated(self) -> list[BandImpedance]:
        """Return the impedances that are off by each of the deviations."""
        return [replace(self, value=self.value + part) for part in self.deviation.T]


def smoothed(ratio: Complexes, variance: Array, counted: Array) -> tuple[Complexes, Array]:
    """Return the most likely Z of the bands, and a covariance of it.

    Neighbours differ by about `BAND_STEP`: Σ |Z_b − ratio_b|²/variance_b + Σ |Z_b −
    Z_{b+1}|²/(0.3 s_b)² is least, with s the size of Z there. Bands with small variance keep their
    ratio; others follow their neighbours.
    """
    weight = 1 / np.maximum(variance, 1e-6 * np.abs(ratio) ** 2)
    value = ratio
    for _ in range(4):
        near, squares = (
            np.convolve(v, np.ones(5))[2:-2] for v in (weight, weight * np.abs(value) ** 2)
        )
        size = np.sqrt(squares / near)
        tie = 1 / (BAND_STEP * (size[1:] + size[:-1]) / 2) ** 2
        ties = np.diag(np.append(tie, 0.0) + np.insert(tie, 0, 0.0))
        ties -= np.diag(tie, 1) + np.diag(tie, -1)
        inverse = np.linalg.inv(np.diag(weight) + ties)
        value = inverse @ (weight * ratio)
    covariance = inverse @ (np.diag(weight**2 * counted) + ties) @ inverse.T
    return value, (covariance + covariance.T) / 2
