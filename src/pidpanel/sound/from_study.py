"""The sound of a study: the one place in `sound` that reads the section ``sound``.

The panel enters as arrays: `WettedFace`.
"""

from __future__ import annotations

import sys
from itertools import pairwise
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.geometry.plane_waves import MovedFace, PanelQuadrature, WettedFace
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.sound import field
from pidpanel.sound.field import SoundExcitation
from pidpanel.sound.field_files import ADDED_VOLUME, DIFFUSE, MODAL_FORCE, read_table, write_tables
from pidpanel.sound.radiation import Air, tabulate_added_mass
from pidpanel.sound.spectrum import PRESSURE_FACTOR, Spectrum
from pidpanel.sound.table import read_spectrum
from pidpanel.sound.wavenumber_table import WavenumberTable, constant_table
from pidpanel.study import Study
from pidpanel.study.response import Radiation
from pidpanel.study.sound import Sound

if TYPE_CHECKING:  # slow to import
    import pandas as pd

WETTED_SIDES = {"one_side": 1, "two_sides": 2}


def spectrum_of(sound: Sound) -> Spectrum:
    """Return the spectrum of a study, at ``oaspl_db`` or ``shift_db`` higher.

    The overall level is that of the whole table, also outside the range where a response is
    computed.

    Raises
    ------
    SpectrumError
        If the table cannot be read (`read_spectrum`).
    """
    spectrum = read_spectrum(sound.spectrum).shifted(sound.shift_db)
    if sound.oaspl_db is None:
        return spectrum
    return spectrum.shifted(sound.oaspl_db - spectrum.oaspl)


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
    factor = sound.loaded_sides * PRESSURE_FACTOR[sound.pressure_reference]
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


def excitation_of(sound: Sound, table: WavenumberTable) -> SoundExcitation:
    """Return the sound of a study on a panel of which `modal_force_table` made the table."""
    return SoundExcitation(
        spectrum_of(sound), table, sound.speed_m_s, sound.pressure_reference, sound.loaded_sides
    )


def read_air(
    study: Study, radiation: Radiation, modal_force: WavenumberTable, path: Path | None
) -> Air | None:
    """Read the air on the panel of a study from ``sound/air.nc``; None where it is left out."""
    if radiation == "none":
        return None
    if path is None:
        raise ValueError(f"radiation = {radiation}: the file of the air is required")
    sound = study.acoustics
    diffuse = modal_force if sound.field == "diffuse" else read_table(path, DIFFUSE)
    volume = read_table(path, ADDED_VOLUME) if study.response.air_mass else None
    sides = WETTED_SIDES[radiation]
    return Air(sound.air_density_kg_m3, sound.speed_m_s, sides, diffuse, volume)


def modal_force_table(sound: Sound, frequency_max: float, shapes: MovedFace) -> WavenumberTable:
    """Tabulate G [m⁴] of the field of a study over the wavenumber, up to a frequency [Hz]."""
    k_max = float(field.wavenumber(frequency_max, sound.speed_m_s))
    face = PanelQuadrature.from_face(shapes)
    match sound.field:
        case "diffuse":
            return field.tabulate_diffuse(k_max, face)
        case "plane_wave" | "progressive_wave":
            return field.tabulate_plane_wave(k_max, sound.incidence, sound.azimuth, face)
        case "uncorrelated" | "uniform":
            return constant_table(k_max, _constant_force(sound, shapes))


def modal_force_at(sound: Sound, frequency: float, shapes: MovedFace) -> Array | Complexes:
    """Return G (n, n) [m⁴] of the field of a study at one frequency [Hz], without a table.

    Parameters are those of `modal_force_table`.
    """
    k, face = field.wavenumber(frequency, sound.speed_m_s), PanelQuadrature.from_face(shapes)
    match sound.field:
        case "diffuse":
            if np.isfinite(face.wavenumber):  # a condensed face is a grid
                return field.diffuse_modal_force_on_grid(float(k), face)
            return field.diffuse_modal_force(float(k), face)
        case "plane_wave" | "progressive_wave":
            force = field.plane_wave_modal_force([k], sound.incidence, sound.azimuth, face)
            return np.asarray(force[0], np.complex128)
        case "uncorrelated" | "uniform":
            return _constant_force(sound, shapes)


def _constant_force(sound: Sound, shapes: MovedFace) -> Array:
    """Return G of a field that is the same at every frequency."""
    if sound.field == "uniform":
        return field.uniform_modal_force(PanelQuadrature.from_face(shapes))
    area = field.lumped_area(shapes.vertex_position, shapes.cells)
    return field.uncorrelated_modal_force(area, shapes.shape_at_vertices)


def air_tables(
    sound: Sound, shapes: WettedFace, k_max: float, *, air_mass: bool
) -> dict[str, WavenumberTable]:
    """Tabulate the reaction of the air on one side of the panel to its motion, up to k_max [rad/m].

    `DIFFUSE` is G of the diffuse field [m⁴], which gives the radiation resistance whatever field
    drives the panel; left out where that is the field of the study. `ADDED_VOLUME` is V of the
    added mass [m³]; left out where the air has no mass (``response.air_mass``).
    """
    face = PanelQuadrature.from_face(shapes, shapes.face_overlap)
    tables = {}
    if sound.field != "diffuse":
        tables[DIFFUSE] = field.tabulate_diffuse(k_max, face)
    if air_mass:
        tables[ADDED_VOLUME] = tabulate_added_mass(k_max, face)
    return tables


def write_sound(study: Study, shapes: WettedFace, output: Files) -> None:
    """Write the bands, the modal force of the field and, if requested, the tables of the air.

    Parameters
    ----------
    output
        spectrum, a CSV table, modal_force and, for the air, air.

    Raises
    ------
    ValueError
        If `modal_force_table` or `air_tables` raises it.
    """
    band_table(study.acoustics).to_csv(output.spectrum, index=False, float_format="%.7g")
    force = modal_force_table(study.acoustics, study.response.frequency_hz[1], shapes)
    _tell("modal force", force)
    attributes = {**stamp(study), "field": study.acoustics.field}
    write_tables(output.modal_force, {MODAL_FORCE: force}, attributes)
    if (air_nc := output.get("air")) is not None:
        k_max, air_mass = force.wavenumber_max, study.response.air_mass
        air = air_tables(study.acoustics, shapes, k_max, air_mass=air_mass)
        for name, table in air.items():
            _tell(name.replace("_", " "), table)
        write_tables(air_nc, air, stamp(study))


def _tell(title: str, table: WavenumberTable) -> None:
    """Print the size of a table to the log of the stage."""
    count, shapes = table.even.shape[:2]
    text = f"{title}: {shapes} shapes at {count} wavenumbers to {table.wavenumber_max:.3g} rad/m"
    print(text, file=sys.stderr)
