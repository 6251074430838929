"""C_e, m_a and the bed's own force from a record of the coupled run.

The sound is known, so what the patch would do under it with a linear damper, r, is known too and
is independent of the bed's own force n: in a band

    Z = Σ a σ r* / Σ a v r*,    σ = Z v + n,

sums over its lines and over the stations. A ratio of σ to v alone would hold the panel's answer to
n. The impedance is that of the best linear approximation at the motion that the panel has.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from pidpanel.arrays import Array, Complexes


@dataclass(frozen=True)
class Spectra:
    """Fourier coefficients of a window of a record, e^{iωt}, so scaled that |x|² is a PSD.

    Attributes
    ----------
    frequency
        (nf,) [Hz].
    values
        (nf, s) of each column.
    """

    frequency: Array
    values: Complexes


def taper(count: int, share: float = 0.1) -> Array:
    """Return a window (count,) that rises and falls by a cosine over a share of its length.

    Examples
    --------
    >>> taper(5, 0.25).tolist()
    [0.0, 1.0, 1.0, 1.0, 0.0]
    """
    distance = np.minimum(np.arange(count), np.arange(count)[::-1]) / (share * (count - 1))
    window: Array = 0.5 - 0.5 * np.cos(np.pi * np.minimum(distance, 1.0))
    return window


def spectra_of(rows: Array, interval: float) -> Spectra:
    """Return the spectra of the columns of a record without their means.

    Parameters
    ----------
    rows
        (m, s).
    interval
        Between the rows [s].
    """
    window = taper(len(rows))
    scale = np.sqrt(2 * interval / (window @ window))
    values = np.fft.rfft((rows - rows.mean(axis=0)) * window[:, None], axis=0) * scale
    frequency = np.fft.rfftfreq(len(rows), interval).astype(np.float64)
    return Spectra(frequency, values)


def pressure_spectra(impulse: Array, interval: float) -> Spectra:
    """Return the spectra of the force per area of which the rows are the impulse so far.

    A difference of two rows is the mean over the time between them, sinc(fΔ) of a tone half an
    interval later.

    Parameters
    ----------
    impulse
        (m + 1, s) [N s/m²].
    interval
        Δ between the rows [s].
    """
    mean = spectra_of(np.diff(impulse, axis=0) / interval, interval)
    turn = np.exp(-1j * np.pi * mean.frequency * interval) / np.sinc(mean.frequency * interval)
    return Spectra(mean.frequency, mean.values * turn[:, None])


def band_sums(frequency: Array, values: Array | Complexes, edge: Array) -> Array | Complexes:
    """Return the sums over the lines of each band, (bands, …).

    Parameters
    ----------
    frequency, values
        (nf,) rising [Hz] and (nf, …).
    edge
        (bands, 2) [Hz]; a line at an upper edge belongs to the next band.
    """
    upto = np.concatenate([np.zeros((1, *values.shape[1:])), np.cumsum(values, axis=0)])
    at = np.searchsorted(frequency, edge)
    return upto[at[:, 1]] - upto[at[:, 0]]


@dataclass(frozen=True)
class BandImpedance:
    """Cross-spectra of which Z of a band is the ratio; those of several records add up.

    Of each line x = Σ a σ r* and y = Σ a v r*, sums over the stations.

    Attributes
    ----------
    force, velocity
        (bands,) Σ x and Σ y over the lines of the band.
    force_square, velocity_square, product
        (bands,) Σ |x|², Σ |y|² and Σ x y*.
    moment
        (bands,) Σ f y [Hz].
    """

    force: Complexes
    velocity: Complexes
    force_square: Array
    velocity_square: Array
    product: Complexes
    moment: Complexes

    @property
    def frequency(self) -> Array:
        """(bands,) mean frequency of the motion in each band [Hz]: there Z is the ratio."""
        found: Array = (self.moment / self.velocity).real
        return found

    @property
    def ratio(self) -> Complexes:
        """(bands,) Z of each band on its own [N s/m³]."""
        found: Complexes = self.force / self.velocity
        return found

    @property
    def variance(self) -> Array:
        """(bands,) of the ratio, from the scatter of the lines, Σ |x − Z y|² / |Σ y|²."""
        z = self.ratio
        scatter = self.force_square - 2 * (z.conj() * self.product).real
        scatter = scatter + np.abs(z) ** 2 * self.velocity_square
        found: Array = LINES_PER_FREEDOM * np.maximum(scatter, 0.0) / np.abs(self.velocity) ** 2
        return found

    @property
    def value(self) -> Complexes:
        """(bands,) Z [N s/m³], smooth over the bands where they do not tell it; see `smoothed`."""
        return smoothed(self.ratio, self.variance)[0]

    @property
    def error(self) -> Array:
        """(bands,) standard error of the real part of `value`, and of the imaginary one."""
        found: Array = np.sqrt(smoothed(self.ratio, self.variance)[1] / 2)
        return found


LINES_PER_FREEDOM = 1.15
"""Lines of a tapered window for one that is independent of the others [1]."""

STEP_OF_BAND = 0.3
"""By which Z may differ from one third octave to the next, over its size [1]: that of a mass
grows by 26 %, that of an agitated bed is flat."""


def smoothed(ratio: Complexes, variance: Array) -> tuple[Complexes, Array]:
    """Return the most likely Z of bands, and its variance.

    Neighbours differ by about `STEP_OF_BAND`:
    Σ |Z_b − ratio_b|²/variance_b + Σ |Z_b − Z_{b+1}|²/(0.3 s_b)² is least, s the size of Z there.
    Bands that are known well stay as they are; others follow their neighbours.

    Parameters
    ----------
    ratio, variance
        (bands,) of Z of each band on its own.
    """
    weight = 1 / np.maximum(variance, 1e-6 * np.abs(ratio) ** 2 + 1e-300)
    found = ratio
    for _ in range(4):
        near = np.convolve(weight, np.ones(5), "same")
        size = np.sqrt(np.convolve(weight * np.abs(found) ** 2, np.ones(5), "same") / near)
        tie = 1 / (STEP_OF_BAND * (size[1:] + size[:-1]) / 2) ** 2
        matrix = np.diag(weight) - np.diag(tie, 1) - np.diag(tie, -1)
        matrix += np.diag(np.append(tie, 0.0) + np.insert(tie, 0, 0.0))
        found = np.linalg.solve(matrix, weight * ratio)
    variance_of_found: Array = np.diagonal(np.linalg.inv(matrix)).copy()
    return found, variance_of_found


def band_impedance(
    frequency: Array,
    pressure: Complexes,
    velocity: Complexes,
    instrument: Complexes,
    area: Array,
    edge: Array,
) -> BandImpedance:
    """Return the cross-spectra of a record with an instrument.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    pressure, velocity, instrument
        (nf, k) σ, v and r of the stations of one patch.
    area
        (k,) for which they stand [m²].
    edge
        (bands, 2) [Hz].
    """
    x, y = (pressure * instrument.conj()) @ area, (velocity * instrument.conj()) @ area

    def total(values: Array | Complexes) -> Any:
        return band_sums(frequency, values, edge)

    return BandImpedance(
        force=total(x),
        velocity=total(y),
        force_square=total(np.abs(x) ** 2),
        velocity_square=total(np.abs(y) ** 2),
        product=total(x * y.conj()),
        moment=total(frequency * y),
    )


def over_frequency(frequency: Array, centre: Array, value: Complexes) -> Complexes:
    """Return Z at (nf,) frequencies [Hz] from its bands: C_e and m_a linear over ln f.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    centre, value
        (bands,) rising [Hz] and Z [N s/m³].
    """
    place, at = np.log(np.maximum(frequency, centre[0] / 2)), np.log(centre)
    damping = np.interp(place, at, value.real)
    mass = np.interp(place, at, value.imag / (2 * np.pi * centre))
    found: Complexes = damping + 2j * np.pi * frequency * mass
    return found


@dataclass(frozen=True)
class OwnForce:
    """PSD of the part of the bed's force that is not linear in the motion.

    Attributes
    ----------
    independent
        (bands,) of the mean over the cells of one station, its part that differs from station to
        station: falls with the number of cells [Pa²/Hz].
    common
        (bands,) the part that all stations share [Pa²/Hz].
    common_variance
        (bands,) of the common part, of chance alone [Pa⁴/Hz²].
    """

    independent: Array
    common: Array
    common_variance: Array

    @property
    def likely_common(self) -> Array:
        """(bands,) c c²/(c² + variance): what is no more than chance counts little, of any sign.

        Of no common part the mean is zero, which it would not be if what is negative were left out;
        a patch of 1000 cells is moved by a common part of a thousandth as much as by all of the
        other.
        """
        square = self.common**2
        found: Array = self.common * square / np.maximum(square + self.common_variance, 1e-300)
        return found


def own_force(frequency: Array, own: Complexes, edge: Array) -> OwnForce:
    """Return the PSDs of n = σ − Z v of the stations of a patch.

    Parameters
    ----------
    frequency, own
        (nf,) [Hz] and (nf, k) n, so scaled that |n|² is a PSD.
    edge
        (bands, 2) [Hz].
    """
    stations = own.shape[1]
    every = np.sum(np.abs(own) ** 2, axis=1)
    together = np.abs(own.sum(axis=1)) ** 2
    lines = np.asarray(band_sums(frequency, np.ones((len(frequency), 1)), edge))[:, 0]
    single = np.asarray(band_sums(frequency, every, edge)) / lines / stations
    if stations == 1:
        return OwnForce(single, np.zeros_like(single), np.zeros_like(single))
    pairs = stations * (stations - 1)
    common = np.asarray(band_sums(frequency, together - every, edge)) / lines / pairs
    chance = LINES_PER_FREEDOM * (single - common) ** 2 / (lines * pairs)
    return OwnForce(single - common, common, chance)
