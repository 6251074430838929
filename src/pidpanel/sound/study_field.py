"""The spectrum of a study and its field: waves of sources, or what microphones measured."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pidpanel.arrays import Array
from pidpanel.columns import ColumnsError
from pidpanel.sound.field import wavenumber
from pidpanel.sound.microphone_files import read_cross_spectra
from pidpanel.sound.microphones import Microphones
from pidpanel.sound.plane_waves import PlaneWaves
from pidpanel.sound.spectrum import PRESSURE_FACTOR, Spectrum
from pidpanel.sound.table import read_spectrum
from pidpanel.spectra.break_points import BreakPoints
from pidpanel.study.sound import Sound, StatedField

if TYPE_CHECKING:  # slow to import
    import pandas as pd


def spectrum_of(sound: Sound) -> Spectrum:
    """Return the spectrum of a study, at ``oaspl_db`` or ``shift_db`` higher.

    The overall level is that of the whole table, also outside the range where a response is
    computed.

    Raises
    ------
    SpectrumError
        If the table cannot be read (`read_spectrum`).
    """
    spectrum = stated_spectrum(sound).shifted(sound.shift_db)
    if sound.oaspl_db is None:
        return spectrum
    return spectrum.shifted(sound.oaspl_db - spectrum.oaspl)


def stated_spectrum(sound: Sound) -> Spectrum:
    """Return the spectrum of a study as its file has it; that of microphones, their mean.

    Raises
    ------
    ColumnsError
        If the file cannot be read.
    """
    if sound.spectrum is not None:
        return read_spectrum(sound.spectrum)
    measured, level = measured_field(sound)
    frequency = measured.wavenumber * sound.speed_m_s / (2 * np.pi)
    return Spectrum(BreakPoints(frequency, level), "cross-spectra of microphones")


def measured_field(sound: Sound) -> tuple[Microphones, Array]:
    """Return microphones, and the mean PSD on the face (nl,) [Pa²/Hz] that they measured."""
    stated = sound.field
    assert isinstance(stated, StatedField) and stated.cross_spectra and stated.microphones
    return _measured_field(
        stated.cross_spectra, stated.microphones, stated.noise_db, sound.is_free, sound.speed_m_s
    )


def measured_range(sound: Sound) -> tuple[float, float]:
    """Return the lowest and the highest frequency that microphones measured [Hz]."""
    frequency = measured_field(sound)[0].wavenumber * sound.speed_m_s / (2 * np.pi)
    return float(frequency[0]), float(frequency[-1])


@lru_cache(maxsize=1)
def _measured_field(
    path: Path, positions: Path, noise_db: float, is_free: bool, speed: float
) -> tuple[Microphones, Array]:
    read = read_cross_spectra(path, positions)
    if not is_free and np.any(read.position[:, 2] < 0):
        raise ColumnsError([f"{positions}: z_m: must be at least 0 in a baffle, on its front"])
    k = wavenumber(read.frequency, speed)
    microphones = Microphones(read.position, 10 ** (noise_db / 10), not is_free, k, read.spectra)
    expected = np.diagonal(microphones.expected(k), axis1=1, axis2=2)
    own = np.diagonal(read.spectra, axis1=1, axis2=2).real
    level = np.mean(own / expected, axis=1)
    return replace(microphones, spectra=read.spectra / level[:, None, None]), level


def band_table(sound: Sound) -> pd.DataFrame:
    """Return the bands of a study with their levels and the mean PSD on the face of the panel.

    Of a table of PSD, third octaves; the first and the last may reach beyond the table.

    Returns
    -------
    A row per band: ``center_hz``, ``lower_hz``, ``upper_hz``, ``band_spl_db`` [dB re 20 µPa],
    ``surface_pressure_psd_pa2_hz``.
    """
    import pandas as pd

    spectrum = spectrum_of(sound)
    bands, (low, high) = spectrum.bands(), spectrum.reach
    center, edge = bands.center_frequency, np.clip(bands.edge_frequency, low, high)
    mean_square = [spectrum.points.mean_square(*ends) for ends in pairwise(edge.tolist())]
    factor = sound.faces * PRESSURE_FACTOR[sound.reference]
    psd = factor * np.array(mean_square) / np.diff(edge)
    return pd.DataFrame(
        {
            "center_hz": center,
            "lower_hz": edge[:-1],
            "upper_hz": edge[1:],
            "band_spl_db": bands.band_spl,
            "surface_pressure_psd_pa2_hz": psd,
        }
    )


def plane_waves(sound: Sound) -> PlaneWaves:
    """Return the waves of a study with sources, a plane or a progressive wave."""
    if not isinstance(sound.field, StatedField):
        return PlaneWaves.lone(sound.incidence, sound.azimuth)
    sources = sound.field.sources or ()
    angles = np.radians([(source.incidence_deg, source.azimuth_deg) for source in sources])
    power = 10 ** (np.array([source.level_db for source in sources]) / 10)
    return PlaneWaves(angles[:, 0], angles[:, 1], power / power.sum(), sound.field.one_drive)
