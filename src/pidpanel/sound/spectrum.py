"""Sound spectra: band levels with the one-sided pressure PSD equivalent to them, or that PSD.

Levels are in dB re 20 µPa, frequencies in Hz, PSDs one-sided in Pa²/Hz.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass, replace
from typing import ClassVar, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Index
from pidpanel.spectra import third_octaves
from pidpanel.spectra.break_points import BreakPoints

BandKind = Literal["third octave", "octave"]
PressureReference = Literal["surface", "room", "incident"]

REFERENCE_PRESSURE = 20e-6  # p_ref [Pa], ISO 1683

# Width of a band in steps of the band number N, where the exact centre is 10^(N/10) Hz.
BAND_WIDTH: dict[BandKind, int] = {"third octave": 1, "octave": 3}

# PSD of the pressure on the face over the PSD of the stated pressure.
#
# `surface`: the level is that of the blocked pressure on the face, used as stated.
# `room`: the level is the average over the volume of a diffuse field; a rigid face doubles its PSD.
# `incident`: the level is that of an incoming wave alone; a rigid face doubles its pressure.
PRESSURE_FACTOR: dict[PressureReference, float] = {"surface": 1.0, "room": 2.0, "incident": 4.0}


class SpectrumError(ValueError):
    """A spectrum that cannot be used; the message names place, value and what is allowed."""


class Spectrum(ABC):
    """Sound pressure over frequency."""

    rows: ClassVar[str]  # what its table has, in a word
    source: str

    @property
    @abstractmethod
    def reach(self) -> tuple[float, float]:
        """Lowest and highest frequency [Hz]; nothing is extrapolated."""

    @property
    @abstractmethod
    def jumps(self) -> Array:
        """Frequencies at which the PSD jumps [Hz]."""

    @abstractmethod
    def psd(self, frequency: Array) -> Array:
        """Return the PSD (nf,) [Pa²/Hz] at frequencies within `reach` [Hz]."""

    @abstractmethod
    def mean_square(self, low: float, high: float) -> float:
        """Return ∫ S df between two frequencies [Pa²], of what is within `reach`."""

    @abstractmethod
    def shifted(self, decibels: float) -> Self:
        """Return the same spectrum, higher everywhere by `decibels` [dB]."""

    @abstractmethod
    def bands(self) -> "BandSpectrum":
        """Return the levels in bands."""

    @property
    def oaspl(self) -> float:
        """Overall level [dB re 20 µPa] of all that the table has."""
        return float(10 * np.log10(self.mean_square(*self.reach) / REFERENCE_PRESSURE**2))

    def pressure_factor(self, oaspl: float) -> float:
        """Return S_p at the overall level `oaspl` [dB re 20 µPa] over S_p of the table [1]."""
        return float(10 ** ((oaspl - self.oaspl) / 10))

    def at_oaspl(self, oaspl: float) -> Self:
        """Return the same shape at the overall level `oaspl` [dB re 20 µPa].

        The overall level is that of the whole table, also outside the range where a response is
        computed.
        """
        return self.shifted(oaspl - self.oaspl)


@dataclass(frozen=True)
class BandSpectrum(Spectrum):
    """Sound pressure levels in adjoining octave or third-octave bands.

    Examples
    --------
    >>> spectrum = BandSpectrum("octave", np.array([27, 30]), np.array([100.0, 100.0]))
    >>> round(spectrum.oaspl, 4)
    103.0103
    >>> spectrum.edge_frequency.round(1).tolist()
    [354.8, 707.9, 1412.5]
    """

    rows: ClassVar[str] = "bands"
    kind: BandKind  # `"third octave"` or `"octave"`
    # (n_bands,) N, where the exact base-10 centre is 10^(N/10) Hz (IEC 61260-1:2014, 5.2-5.5): N =
    # 30 is 1 kHz. Octaves sit at multiples of 3. Adjoining bands, rising.
    band_number: Index
    band_spl: Array  # (n_bands,) band levels [dB re 20 µPa]
    source: str = ""

    @property
    def center_frequency(self) -> Array:
        """(n_bands,) exact centres 10^(N/10) [Hz]."""
        return third_octaves.center_frequency(self.band_number)

    @property
    def edge_frequency(self) -> Array:
        """(n_bands + 1,) exact edges 10^((N ± b/2)/10) [Hz], b = 1 for thirds, 3 for octaves."""
        edge = third_octaves.edge_frequency(self.band_number, BAND_WIDTH[self.kind])
        return np.append(edge[:, 0], edge[-1, 1])

    @property
    def oaspl(self) -> float:
        """Overall level 10 log10 Σ 10^(L/10) [dB re 20 µPa] of all bands of the table."""
        return float(10 * np.log10(np.sum(10.0 ** (self.band_spl / 10))))

    @property
    def reach(self) -> tuple[float, float]:
        """Edges of the lowest and of the highest band [Hz]."""
        edge = self.edge_frequency
        return float(edge[0]), float(edge[-1])

    @property
    def jumps(self) -> Array:
        """(n_bands + 1,) the edges [Hz]."""
        return self.edge_frequency

    def psd(self, frequency: Array) -> Array:
        """Return p_ref² 10^(L/10) / (f_u − f_l) for f_l ≤ f < f_u (nf,) [Pa²/Hz]."""
        edge = self.edge_frequency
        band = np.searchsorted(edge, frequency, side="right") - 1
        band_psd = self._band_mean_square / np.diff(edge)
        return band_psd[np.minimum(band, band_psd.size - 1)]

    def mean_square(self, low: float, high: float) -> float:
        """Return ∫ S df between two frequencies [Pa²]; of each band its share."""
        edge = self.edge_frequency
        width = np.diff(np.clip(edge, low, high))
        return float(np.sum(self._band_mean_square * width / np.diff(edge)))

    @property
    def _band_mean_square(self) -> Array:
        mean_square: Array = REFERENCE_PRESSURE**2 * 10.0 ** (self.band_spl / 10)
        return mean_square

    def shifted(self, decibels: float) -> Self:
        """Return the same spectrum with every band `decibels` [dB] higher."""
        return replace(self, band_spl=self.band_spl + decibels)

    def bands(self) -> "BandSpectrum":
        """Return the spectrum itself."""
        return self


@dataclass(frozen=True)
class PsdSpectrum(Spectrum):
    """A pressure PSD of break points [Pa²/Hz].

    Examples
    --------
    >>> flat = PsdSpectrum(BreakPoints(np.array([100.0, 1100.0]), np.array([1.0, 1.0])))
    >>> round(flat.oaspl, 4)
    123.9794
    """

    rows: ClassVar[str] = "rows"
    points: BreakPoints
    source: str = ""

    @property
    def reach(self) -> tuple[float, float]:
        """The first and the last frequency [Hz]."""
        return float(self.points.frequency[0]), float(self.points.frequency[-1])

    @property
    def jumps(self) -> Array:
        """Frequencies that have two rows [Hz]."""
        return self.points.jumps

    def psd(self, frequency: Array) -> Array:
        """Return the PSD (nf,) [Pa²/Hz], a power of f between two rows."""
        return self.points(frequency)

    def mean_square(self, low: float, high: float) -> float:
        """Return ∫ S df between two frequencies [Pa²], in closed form."""
        return self.points.mean_square(low, high)

    def shifted(self, decibels: float) -> Self:
        """Return the same spectrum with every row `decibels` [dB] higher."""
        return replace(
            self, points=replace(self.points, psd=self.points.psd * 10 ** (decibels / 10))
        )

    def bands(self) -> BandSpectrum:
        """Return the third octaves that the rows reach, each with the mean square within them."""
        low, high = 10 * np.log10(self.reach)
        number = np.arange(np.floor(low + 0.5 + 1e-9), np.ceil(high + 0.5 - 1e-9)).astype(int)
        edges = third_octaves.edge_frequency(number)
        mean_square = [self.mean_square(*edge) for edge in edges.tolist()]
        return BandSpectrum(
            "third octave",
            number,
            10 * np.log10(np.array(mean_square) / REFERENCE_PRESSURE**2),
            self.source,
        )


def pressure_psd(
    spectrum: Spectrum,
    frequency: ArrayLike,
    pressure_reference: PressureReference = "surface",
    loaded_sides: int = 1,
) -> Array:
    """Return the one-sided PSD (nf,) [Pa²/Hz] of the pressure on the face.

    c times that of the spectrum. Of band levels it is constant in each band, which integrates back
    to its level; c is 1, 2 or 4 by `pressure_reference` (see `PRESSURE_FACTOR`). Two loaded sides
    double the PSD: fields of that level on both faces, independent of one another. (Where the wave
    is longer than the way round the panel the two are not, and partly cancel.)

    Raises
    ------
    SpectrumError
        Where a frequency lies outside the table: nothing is extrapolated.

    Examples
    --------
    >>> spectrum = BandSpectrum("octave", np.array([30]), np.array([94.0]))
    >>> psd = pressure_psd(spectrum, [1000.0])
    >>> round(float(psd[0] * np.diff(spectrum.edge_frequency)[0]), 3)  # 94 dB is 1 Pa rms
    1.005
    """
    frequency = np.asarray(frequency, dtype=np.float64)
    low, high = spectrum.reach
    outside = ~((frequency >= low) & (frequency <= high))  # also true of NaN
    if np.any(outside):
        raise SpectrumError(
            f"frequency = {frequency[outside].flat[0]:g} Hz: the {spectrum.rows} reach from "
            f"{low:.6g} to {high:.6g} Hz and are not extrapolated"
        )
    return loaded_sides * PRESSURE_FACTOR[pressure_reference] * spectrum.psd(frequency)
