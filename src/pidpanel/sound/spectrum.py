"""Sound spectra: band levels with the one-sided pressure PSD equivalent to them, or that PSD.

Levels are in dB re 20 µPa, frequencies in Hz, PSDs one-sided in Pa²/Hz.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import TYPE_CHECKING, ClassVar, Literal, Self

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Index
from pidpanel.columns import ColumnsError
from pidpanel.spectra import third_octaves
from pidpanel.spectra.break_points import BreakPoints

if TYPE_CHECKING:  # slow to import
    import pandas as pd

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


@dataclass(frozen=True)
class Spectrum:
    """A pressure PSD of break points [Pa²/Hz].

    Examples
    --------
    >>> flat = Spectrum(BreakPoints(np.array([100.0, 1100.0]), np.array([1.0, 1.0])))
    >>> round(flat.oaspl, 4)
    123.9794
    """

    rows: ClassVar[str] = "rows"  # what its table has, in a word
    points: BreakPoints
    source: str = ""

    @property
    def reach(self) -> tuple[float, float]:
        """Lowest and highest frequency [Hz]; nothing is extrapolated."""
        return float(self.points.frequency[0]), float(self.points.frequency[-1])

    @property
    def jumps(self) -> Array:
        """Frequencies at which the PSD jumps [Hz]."""
        return self.points.jumps

    @property
    def oaspl(self) -> float:
        """Overall level [dB re 20 µPa] of all that the table has."""
        return float(_level(self.points.mean_square(*self.reach)))

    def pressure_factor(self, oaspl: float) -> float:
        """Return S_p at the overall level `oaspl` [dB re 20 µPa] over S_p of the table [1]."""
        return float(10 ** ((oaspl - self.oaspl) / 10))

    def shifted(self, decibels: float) -> Self:
        """Return the same spectrum, higher everywhere by `decibels` [dB]."""
        psd = self.points.psd * 10 ** (decibels / 10)
        return replace(self, points=replace(self.points, psd=psd))

    def bands(self) -> BandSpectrum:
        """Return the third octaves that the rows reach, each with the mean square within them."""
        low, high = 10 * np.log10(self.reach)
        number = np.arange(np.floor(low + 0.5 + 1e-9), np.ceil(high + 0.5 - 1e-9)).astype(int)
        edges = third_octaves.edge_frequency(number)
        mean_square = [self.points.mean_square(*edge) for edge in edges.tolist()]
        return BandSpectrum.of_levels("third octave", number, _level(mean_square), self.source)


@dataclass(frozen=True, kw_only=True)
class BandSpectrum(Spectrum):
    """Sound pressure levels in adjoining octave or third-octave bands; the PSD jumps between them.

    Examples
    --------
    >>> spectrum = BandSpectrum.of_levels("octave", np.array([27, 30]), np.array([100.0, 100.0]))
    >>> round(spectrum.oaspl, 4)
    103.0103
    >>> spectrum.edge_frequency.round(1).tolist()
    [354.8, 707.9, 1412.5]
    """

    rows: ClassVar[str] = "bands"
    kind: BandKind
    # (n_bands,) N, where the exact base-10 centre is 10^(N/10) Hz (IEC 61260-1:2014, 5.2-5.5): N =
    # 30 is 1 kHz. Octaves sit at multiples of 3. Adjoining bands, rising.
    band_number: Index
    band_spl: Array  # (n_bands,) band levels [dB re 20 µPa]

    @classmethod
    def of_levels(
        cls, kind: BandKind, band_number: Index, band_spl: Array, source: str = ""
    ) -> Self:
        """Return the spectrum of band levels: p_ref² 10^(L/10) / (f_u − f_l) for f_l ≤ f < f_u."""
        edges = third_octaves.edge_frequency(band_number, BAND_WIDTH[kind])
        psd = REFERENCE_PRESSURE**2 * 10.0 ** (band_spl / 10) / np.diff(edges)[:, 0]
        points = BreakPoints(edges.ravel(), np.repeat(psd, 2))
        return cls(points, source, kind=kind, band_number=band_number, band_spl=band_spl)

    @property
    def center_frequency(self) -> Array:
        """(n_bands,) exact centres 10^(N/10) [Hz]."""
        return third_octaves.center_frequency(self.band_number)

    @property
    def edge_frequency(self) -> Array:
        """(n_bands + 1,) exact edges 10^((N ± b/2)/10) [Hz], b = 1 for thirds, 3 for octaves."""
        return np.append(self.points.frequency[::2], self.points.frequency[-1])

    @property
    def jumps(self) -> Array:
        """(n_bands + 1,) the edges [Hz]."""
        return self.edge_frequency

    def shifted(self, decibels: float) -> Self:
        """Return the same spectrum with every band `decibels` [dB] higher."""
        return replace(super().shifted(decibels), band_spl=self.band_spl + decibels)

    def bands(self) -> BandSpectrum:
        """Return the spectrum itself."""
        return self


def whole_thirds(spectrum: Spectrum) -> BandSpectrum:
    """Return the levels of the third octaves that lie within a spectrum."""
    low, high = 10 * np.log10(spectrum.reach)
    number = np.arange(np.ceil(low + 0.5 - 1e-9), np.floor(high + 0.5 + 1e-9)).astype(int)
    edges = third_octaves.edge_frequency(number).tolist()
    levels = _level([spectrum.points.mean_square(*edge) for edge in edges])
    return BandSpectrum.of_levels("third octave", number, levels, spectrum.source)


def envelope(spectra: Sequence[Spectrum]) -> tuple[BandSpectrum, Index]:
    """Return the highest level of spectra in each third octave, and whose it is (n_bands,).

    The PSD of an octave counts in each of its thirds, and a PSD by its mean square.

    Raises
    ------
    ColumnsError
        If a spectrum has no whole third octave, or they leave a gap between them.

    Examples
    --------
    >>> low, high = np.array([100.0, 110.0]), np.array([104.0, 90.0])
    >>> bands = (np.array([27, 28]), low), (np.array([28, 29]), high)
    >>> highest, governing = envelope([BandSpectrum.of_levels("third octave", *b) for b in bands])
    >>> highest.band_spl.tolist(), governing.tolist()
    ([100.0, 110.0, 90.0], [0, 0, 1])
    """
    thirds = [whole_thirds(spectrum) for spectrum in spectra]
    for place, bands in enumerate(thirds, start=1):
        if not bands.band_number.size:
            raise ColumnsError([f"table {place} has no whole third octave"])
    numbers = np.concatenate([bands.band_number for bands in thirds])
    number = np.arange(numbers.min(), numbers.max() + 1)
    if (gap := np.setdiff1d(number, numbers)).size:
        center = third_octaves.center_frequency(gap[0])
        raise ColumnsError([f"no table has the third octave at {center:.4g} Hz; must adjoin"])
    centers = third_octaves.center_frequency(number)
    levels = np.array([on_bands(bands, centers) for bands in thirds])
    highest = BandSpectrum.of_levels("third octave", number, np.nanmax(levels, axis=0))
    return highest, np.asarray(np.nanargmax(levels, axis=0), np.int64)


def on_bands(spectrum: Spectrum, center: ArrayLike) -> Array:
    """Return the levels of a spectrum in third octaves (n,) [dB]; NaN in those that it lacks."""
    bands, number = whole_thirds(spectrum), np.round(10 * np.log10(center)).astype(int)
    levels = dict(zip(bands.band_number.tolist(), bands.band_spl.tolist(), strict=True))
    return np.array([levels.get(band, np.nan) for band in number.tolist()])


def _level(mean_square: ArrayLike) -> Array:
    """Return levels of mean squares [Pa²], dB re 20 µPa."""
    return 10 * np.log10(np.asarray(mean_square) / REFERENCE_PRESSURE**2)


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
        If a frequency is outside the table: nothing is extrapolated.

    Examples
    --------
    >>> spectrum = BandSpectrum.of_levels("octave", np.array([30]), np.array([94.0]))
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
    return loaded_sides * PRESSURE_FACTOR[pressure_reference] * spectrum.points(frequency)


def band_table(spectrum: Spectrum, factor: float) -> pd.DataFrame:
    """Return the bands of a spectrum with their levels and the mean PSD on the face of the panel.

    Of a table of PSD, third octaves; the first and the last may reach beyond the table.

    Parameters
    ----------
    factor
        PSD on the face over that of the spectrum [1].

    Returns
    -------
    A row per band: ``center_hz``, ``lower_hz``, ``upper_hz``, ``band_spl_db`` [dB re 20 µPa],
    ``surface_pressure_psd_pa2_hz``.
    """
    import pandas as pd

    bands, (low, high) = spectrum.bands(), spectrum.reach
    center, edge = bands.center_frequency, np.clip(bands.edge_frequency, low, high)
    mean_square = [spectrum.points.mean_square(*ends) for ends in pairwise(edge.tolist())]
    return pd.DataFrame(
        {
            "center_hz": center,
            "lower_hz": edge[:-1],
            "upper_hz": edge[1:],
            "band_spl_db": bands.band_spl,
            "surface_pressure_psd_pa2_hz": factor * np.array(mean_square) / np.diff(edge),
        }
    )
