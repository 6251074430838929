"""The sound of a study: the one place in `sound` that reads the section ``sound``.

The panel enters as arrays: `WettedFace`.
"""

from __future__ import annotations

import sys
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.geometry.plane_waves import MovedFace, PanelQuadrature, WettedFace
from pidpanel.geometry.surface_waves import SurfaceQuadrature
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files
from pidpanel.sound import field
from pidpanel.sound.field import SoundExcitation
from pidpanel.sound.field_files import (
    ADDED_VOLUME,
    DIFFUSE,
    MODAL_FORCE,
    parts_of,
    read_table,
    write_tables,
)
from pidpanel.sound.free_edges import (
    FreePanel,
    FreeSurface,
    checked,
    mesh_error,
    plane_wave_force,
    tabulate_diffuse_room,
    tabulate_free_plane_waves,
    tabulated_panel,
)
from pidpanel.sound.microphone_files import read_microphones
from pidpanel.sound.microphones import (
    MeasuredTable,
    Microphones,
    tabulate_in_room,
    tabulate_on_wall,
)
from pidpanel.sound.plane_waves import PlaneWaves
from pidpanel.sound.radiation import Air, tabulate_added_mass
from pidpanel.sound.spectrum import PRESSURE_FACTOR, Spectrum, band_table
from pidpanel.sound.surface import (
    surface_force,
    tabulate_diffuse_surface,
    tabulate_surface_mass,
    uniform_surface_force,
)
from pidpanel.sound.table import read_envelope
from pidpanel.sound.wavenumber_table import (
    JoinedTable,
    Table,
    WavenumberTable,
    constant_table,
    upper_share,
)
from pidpanel.spectra.break_points import BreakPoints
from pidpanel.study import Study
from pidpanel.study.sound import Sound, StatedField

if TYPE_CHECKING:  # slow to import
    import pandas as pd

SURFACE_REACH = 3.0  # wavenumber to which the mass of the air on a curved face is integrated
FACE_MARGIN = 2.0  # wavenumber to which a face is known over that of its shapes or of the sound

COARSER = 0.5  # vertices of a mesh of the air that shows the error of another one, over its own

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
    spectrum = stated_spectrum(sound).shifted(sound.shift_db)
    if sound.oaspl_db is None:
        return spectrum
    return spectrum.shifted(sound.oaspl_db - spectrum.oaspl)


def stated_spectrum(sound: Sound) -> Spectrum:
    """Return the spectrum of a study as its files have it; that of microphones, their mean.

    Raises
    ------
    ColumnsError
        If a file cannot be read, or several leave a gap between them.
    """
    if sound.spectra:
        return read_envelope(sound.spectra)[0]
    measured, level = measured_field(sound)
    frequency = measured.wavenumber * sound.speed_m_s / (2 * np.pi)
    return Spectrum(BreakPoints(frequency, level), "cross-spectra of microphones")


def bands_on_face(sound: Sound) -> pd.DataFrame:
    """Return the bands of a study: levels and their file, mean PSD on the face of the panel."""
    table = band_table(spectrum_of(sound), sound.faces * PRESSURE_FACTOR[sound.reference])
    names = read_envelope(sound.spectra)[1] if sound.spectra else sound.level_names
    return table.assign(spectrum=np.resize(names, len(table)))


def measured_field(sound: Sound) -> tuple[Microphones, Array]:
    """Return microphones, and the mean PSD on the face (nl,) [Pa²/Hz] that they measured."""
    stated = sound.field
    assert isinstance(stated, StatedField) and stated.cross_spectra and stated.microphones
    files, noise = (stated.cross_spectra, stated.microphones), 10 ** (stated.noise_db / 10)
    return read_microphones(*files, noise, sound.speed_m_s, before_wall=not sound.is_free)


def measured_range(sound: Sound) -> tuple[float, float]:
    """Return the lowest and the highest frequency that microphones measured [Hz]."""
    frequency = measured_field(sound)[0].wavenumber * sound.speed_m_s / (2 * np.pi)
    return float(frequency[0]), float(frequency[-1])


def plane_waves(sound: Sound) -> PlaneWaves:
    """Return the waves of a study with sources, a plane or a progressive wave."""
    if not isinstance(sound.field, StatedField):
        return PlaneWaves.lone(sound.incidence, sound.azimuth)
    sources = sound.field.sources or ()
    angles = np.array([source.angles for source in sources])
    power = 10 ** (np.array([source.level_db for source in sources]) / 10)
    return PlaneWaves(angles[:, 0], angles[:, 1], power / power.sum(), sound.field.one_drive)


def excitation_of(sound: Sound, table: Table) -> SoundExcitation:
    """Return the sound of a study on a panel of which `sound_tables` made the table."""
    return SoundExcitation(spectrum_of(sound), table, sound.speed_m_s, sound.reference, sound.faces)


def read_air(study: Study, modal_force: Table, path: Path | None) -> Air | None:
    """Read the air on the panel of a study from ``sound/air.nc``; None where it is left out."""
    radiation = study.radiation
    if radiation == "none":
        return None
    if path is None:
        raise ValueError(f"radiation = {radiation}: the file of the air is required")
    sound = study.acoustics
    diffuse = modal_force if sound.field == "diffuse" else read_table(path, DIFFUSE)
    volume = {ADDED_VOLUME: read_table(path, ADDED_VOLUME)} if study.response.air_mass else {}
    return air_of(study, {MODAL_FORCE: modal_force, DIFFUSE: diffuse, **volume})


def air_of(study: Study, tables: Mapping[str, Table]) -> Air:
    """Return the air on the panel of a study, of tables by the names of `field_files`."""
    sound, sides = study.acoustics, WETTED_SIDES[study.radiation]
    diffuse = tables.get(DIFFUSE, tables[MODAL_FORCE])
    volume = tables.get(ADDED_VOLUME)
    return Air(sound.air_density_kg_m3, sound.speed_m_s, sides, diffuse, volume)


def sound_tables(study: Study, shapes: WettedFace, *, air: bool) -> dict[str, Table]:
    """Tabulate G of the field of a study [m⁴], and the air if required, over the wavenumber.

    Returns
    -------
    Tables by the names of `field_files`, to the highest frequency of the response.
    """
    sound, k_max = study.acoustics, _highest(study)
    if sound.field_name == "measured":
        return measured_tables(study, shapes, air=air)
    panel = free_panel(study, shapes)
    tables = {} if panel is None else _free_tables(sound, panel, shapes, air=air)
    if panel is not None and panel.wavenumber_max >= k_max:
        return {**tables}
    upper = {MODAL_FORCE: modal_force_table(sound, k_max, shapes)}
    if air and shapes.quadrature_normal is not None:
        surface = SurfaceQuadrature.from_face(shapes)
        upper[ADDED_VOLUME] = tabulate_surface_mass(k_max, SURFACE_REACH * k_max, surface)
        if sound.field != "diffuse":
            upper[DIFFUSE] = tabulate_diffuse_surface(k_max, surface)
    elif air:
        upper |= air_tables(sound, shapes, k_max, air_mass=study.response.air_mass)
    if panel is None:
        return {**upper}
    return {name: JoinedTable(lower, upper[name]) for name, lower in tables.items()}


def _highest(study: Study) -> float:
    """Return the wavenumber of the highest frequency of the response [rad/m]."""
    return float(field.wavenumber(study.response.frequency_hz[1], study.acoustics.speed_m_s))


def measured_tables(study: Study, shapes: WettedFace, *, air: bool) -> dict[str, Table]:
    """Tabulate as `sound_tables`, with a field that microphones measured."""
    diffuse = study.model_copy(update={"sound": study.acoustics.diffuse})
    tables = sound_tables(diffuse, shapes, air=air)
    force = tables[MODAL_FORCE]
    if air:
        tables[DIFFUSE] = force
    microphones, _ = measured_field(study.acoustics)
    face, panel = PanelQuadrature.from_face(shapes), free_panel(study, shapes)
    if panel is None:
        coupling = tabulate_on_wall(_highest(study), face, microphones)
    else:
        coupling = tabulate_in_room(panel, face, microphones)
    return {**tables, MODAL_FORCE: MeasuredTable(force, coupling, microphones)}


def _free_tables(
    sound: Sound, panel: FreePanel, shapes: MovedFace, *, air: bool
) -> dict[str, WavenumberTable]:
    face, tables = _quadrature(shapes), {}
    if sound.field != "diffuse":
        tables[MODAL_FORCE] = tabulate_free_plane_waves(panel, face, plane_waves(sound))
    if sound.field == "diffuse" or air:
        force, volume = tabulate_diffuse_room(panel, face)
        tables[MODAL_FORCE if sound.field == "diffuse" else DIFFUSE] = force
        if air:
            tables[ADDED_VOLUME] = volume
    return tables


def _quadrature(shapes: MovedFace) -> PanelQuadrature | SurfaceQuadrature:
    curved = shapes.quadrature_normal is not None
    return SurfaceQuadrature.from_face(shapes) if curved else PanelQuadrature.from_face(shapes)


def free_panel(study: Study, shapes: MovedFace, share: float = 1.0) -> FreePanel | None:
    """Return the panel of a study with free edges, which its outline decides; None in a baffle.

    Of a curved surface `share` of the vertices is enough to see the error of its mesh.
    """
    if not study.acoustics.is_free:
        return None
    # of a condensed face, as a basis has it
    resolved = float(f"{shapes.quadrature_wavenumber / FACE_MARGIN:.9g}")
    cells = shapes.cells
    if shapes.quadrature_normal is not None:
        resolved = _highest(study)
        cells = np.concatenate([cells[:, [0, k, k + 1]] for k in range(1, cells.shape[1] - 1)])
    arrays = (np.ascontiguousarray(a) for a in (shapes.vertex_position, cells))
    outline = tuple((a.tobytes(), a.shape, a.dtype.str) for a in arrays)
    # one for shapes and those that widen them
    return tabulated_panel(outline, resolved, _highest(study), study.acoustics.wall, share)


def load_error_of(study: Study, shapes: MovedFace) -> tuple[Array, Array] | None:
    """Return k and the error of loads by the mesh of the air (`write_tables`); None of a panel."""
    panel, coarser = (free_panel(study, shapes, share) for share in (1.0, COARSER))
    if not (isinstance(panel, FreeSurface) and isinstance(coarser, FreeSurface)):
        return None
    error = mesh_error(panel, coarser, SurfaceQuadrature.from_face(shapes))
    return checked(panel.wavenumber_max), error


def modal_force_table(sound: Sound, k_max: float, shapes: MovedFace) -> WavenumberTable:
    """Tabulate G [m⁴] of the field of a study in a baffle, up to a wavenumber [rad/m]."""
    if shapes.quadrature_normal is not None:
        return _surface_force_table(sound, k_max, SurfaceQuadrature.from_face(shapes))
    face = PanelQuadrature.from_face(shapes)
    match sound.field:
        case "diffuse":
            return field.tabulate_diffuse(k_max, face)
        case "uncorrelated" | "uniform":
            return constant_table(k_max, _constant_force(sound, shapes))
        case _:
            return field.tabulate_plane_waves(k_max, plane_waves(sound), face)


def _surface_force_table(sound: Sound, k_max: float, surface: SurfaceQuadrature) -> WavenumberTable:
    """Tabulate G [m⁴] of a curved surface, each face alone."""
    match sound.field:
        case "diffuse":
            return tabulate_diffuse_surface(k_max, surface)
        case "uniform":
            return constant_table(k_max, uniform_surface_force(surface))
        case _:
            raise ValueError(
                f"field = {sound.field}: must be diffuse or uniform on a curved surface"
            )


def modal_force_at(study: Study, frequency: float, shapes: MovedFace) -> Array | Complexes:
    """Return G (n, n) [m⁴] of the field of a study at one frequency [Hz], without a table."""
    sound = study.acoustics
    k = float(field.wavenumber(frequency, sound.speed_m_s))
    if sound.field_name == "measured":
        return _measured_force_at(study, frequency, k, shapes)
    face = _quadrature(shapes)
    panel = free_panel(study, shapes)
    if panel is None:
        return _baffled_force_at(sound, k, shapes, face)
    is_whole = panel.wavenumber_max >= _highest(study)
    share = 0.0 if is_whole else float(upper_share(k, panel.wavenumber_max))
    lower = 0.0 if share == 1 else (1 - share) * _free_force_at(sound, k, panel, face)
    upper = 0.0 if share == 0 else share * _baffled_force_at(sound, k, shapes, face)
    return np.asarray(lower + upper)


def _measured_force_at(study: Study, frequency: float, k: float, shapes: MovedFace) -> Complexes:
    diffuse = modal_force_at(
        study.model_copy(update={"sound": study.acoustics.diffuse}), frequency, shapes
    )
    microphones, _ = measured_field(study.acoustics)
    face, panel = PanelQuadrature.from_face(shapes), free_panel(study, shapes)
    if panel is None:
        coupling = microphones.on_wall(k, face)
    else:
        coupling = microphones.in_room(k, panel, panel.jumps.couplings(face), face.center)
    force: Complexes = microphones.conditioned(np.array([k]), diffuse[None], coupling[None])[0]
    return force


def _baffled_force_at(
    sound: Sound, k: float, shapes: MovedFace, face: PanelQuadrature | SurfaceQuadrature
) -> Array | Complexes:
    if isinstance(face, SurfaceQuadrature):
        return surface_force(k, face) if sound.field == "diffuse" else uniform_surface_force(face)
    match sound.field:
        case "diffuse":
            if np.isfinite(face.wavenumber):  # a condensed face is a grid
                return field.diffuse_modal_force_on_grid(k, face)
            return field.diffuse_modal_force(k, face)
        case "uncorrelated" | "uniform":
            return _constant_force(sound, shapes)
        case _:
            force = field.plane_wave_modal_force([k], plane_waves(sound), face)
            return np.asarray(force[0], np.complex128)


def _free_force_at(
    sound: Sound, k: float, panel: FreePanel, face: PanelQuadrature | SurfaceQuadrature
) -> Array | Complexes:
    couplings = panel.jumps.couplings(face)
    if sound.field == "diffuse":
        return np.asarray(np.pi / k * panel.impedance(k, couplings).imag, np.float64)
    return plane_wave_force(panel, k, plane_waves(sound), couplings)


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
        If `sound_tables` raises it.
    """
    bands_on_face(study.acoustics).to_csv(output.spectrum, index=False, float_format="%.7g")
    air_nc = output.get("air")
    tables = sound_tables(study, shapes, air=air_nc is not None)
    for name, _, table in parts_of(tables):
        print(f"{name.replace('_', ' ')}: {table.size_text}", file=sys.stderr)
    attributes = {**stamp(study), "field": study.acoustics.field_name}
    force = tables.pop(MODAL_FORCE)
    error, stated = load_error_of(study, shapes), study.acoustics.field
    if isinstance(force, MeasuredTable) and isinstance(stated, StatedField) and stated.averages:
        error = force.average_error(stated.averages, is_level=not study.acoustics.spectra)
    write_tables(output.modal_force, {MODAL_FORCE: force}, attributes, error)
    if air_nc is not None:
        write_tables(air_nc, tables, stamp(study))
