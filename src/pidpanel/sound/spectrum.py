"""Band levels and the one-sided pressure PSD equivalent to them.

Levels are in dB re 20 µPa, frequencies in Hz, PSDs one-sided in Pa²/Hz.
"""

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy.typing import ArrayLike

from pidpanel import third_octaves
from pidpanel.arrays import Array, Index

BandKind = Literal["third octave", "octave"]
PressureReference = Literal["surface", "room", "incident"]

REFERENCE_PRESSURE = 20e-6
"""p_ref [Pa], ISO 1683."""

BAND_WIDTH: dict[BandKind, int] = {"third octave": 1, "octave": 3}
"""Width of a band in steps of the band number N, where the exact centre is 10^(N/10) Hz."""

PRESSURE_FACTOR: dict[PressureReference, float] = {"surface": 1.0, "room": 2.0, "incident": 4.0}
"""PSD of the pressure on the face over the PSD of the stated pressure.

`surface`: the level is that of the blocked pressure on the face, used as stated.
`room`: the level is the average over the volume of a diffuse field; a rigid face doubles its PSD.
`incident`: the level is that of an incoming wave alone; a rigid face doubles its pressure.
"""


class SpectrumError(ValueError):
    """A spectrum that cannot be used; the message names place, value and what is allowed."""


@dataclass(frozen=True)
class BandSpectrum:
    """Sound pressure levels in adjoining octave or third-octave bands.

    Parameters
    ----------
    kind
        `"third octave"` or `"octave"`.
    band_number
        (n_bands,) N, where the exact base-10 centre is 10^(N/10) Hz (IEC 61260-1:2014, 5.2-5.5):
        N = 30 is 1 kHz. Octaves sit at multiples of 3. Adjoining bands, rising.
    band_spl
        (n_bands,) band levels [dB re 20 µPa].

    Examples
    --------
    >>> spectrum = BandSpectrum("octave", np.array([27, 30]), np.array([100.0, 100.0]))
    >>> round(spectrum.oaspl, 4)
    103.0103
    >>> spectrum.edge_frequency.round(1).tolist()
    [354.8, 707.9, 1412.5]
    """

    kind: BandKind
    band_number: Index
    band_spl: Array
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

    def pressure_factor(self, oaspl: float) -> float:
        """Return S_p at the overall level `oaspl` [dB re 20 µPa] over S_p of the table [1]."""
        return float(10 ** ((oaspl - self.oaspl) / 10))

    def shifted(self, decibels: float) -> "BandSpectrum":
        """Return the same spectrum with every band `decibels` [dB] higher."""
        return replace(self, band_spl=self.band_spl + decibels)

    def at_oaspl(self, oaspl: float) -> "BandSpectrum":
        """Return the same shape at the overall level `oaspl` [dB re 20 µPa].

        The overall level is that of all bands of the table, also those outside the range
        where a response is computed.
        """
        return self.shifted(oaspl - self.oaspl)


def pressure_psd(
    spectrum: BandSpectrum,
    frequency: ArrayLike,
    pressure_reference: PressureReference = "surface",
    loaded_sides: int = 1,
) -> Array:
    """Return the one-sided PSD (nf,) [Pa²/Hz] of the pressure on the face, constant in each band.

    S_p(f) = c p_ref² 10^(L/10) / (f_u − f_l) for f_l ≤ f < f_u, so that each band integrates back
    to its level; c is 1, 2 or 4 by `pressure_reference` (see `PRESSURE_FACTOR`). Two loaded sides
    double the PSD: fields of that level on both faces, independent of one another. (Where the wave
    is longer than the way round the panel the two are not, and partly cancel.)

    Raises
    ------
    SpectrumError
        Where a frequency lies outside the bands: nothing is extrapolated.

    Examples
    --------
    >>> spectrum = BandSpectrum("octave", np.array([30]), np.array([94.0]))
    >>> psd = pressure_psd(spectrum, [1000.0])
    >>> round(float(psd[0] * np.diff(spectrum.edge_frequency)[0]), 3)  # 94 dB is 1 Pa rms
    1.005
    """
    frequency = np.asarray(frequency, dtype=np.float64)
    edge = spectrum.edge_frequency
    outside = ~((frequency >= edge[0]) & (frequency <= edge[-1]))  # also true of NaN
    if np.any(outside):
        raise SpectrumError(
            f"frequency = {frequency[outside].flat[0]:g} Hz: the bands reach from {edge[0]:.6g} "
            f"to {edge[-1]:.6g} Hz and are not extrapolated"
        )
    mean_square = REFERENCE_PRESSURE**2 * 10.0 ** (spectrum.band_spl / 10)
    band_psd = loaded_sides * PRESSURE_FACTOR[pressure_reference] * mean_square / np.diff(edge)
    band = np.searchsorted(edge, frequency, side="right") - 1
    return band_psd[np.minimum(band, band_psd.size - 1)]
