"""Band levels and pressure PSD, modal force of the field, air: spectrum.csv, *.nc."""

import sys
from pathlib import Path

import pandas as pd

from pidpanel.panel.basis_files import read_basis
from pidpanel.sound import field
from pidpanel.sound.added_mass import tabulate_added_mass
from pidpanel.sound.field_files import ADDED_VOLUME, DIFFUSE, MODAL_FORCE, write_tables
from pidpanel.sound.from_study import spectrum_of
from pidpanel.sound.spectrum import pressure_psd
from pidpanel.sound.wavenumber_table import constant_table
from pidpanel.stamp import stamp
from pidpanel.study import load_study

if __name__ == "__main__":
    study_path, modes, spectrum_csv, modal_force_nc, *air_nc = sys.argv[1:]
    study = load_study(study_path)
    sound = study.sound
    spectrum = spectrum_of(sound)
    edges = spectrum.edge_frequency
    centre = spectrum.center_frequency
    psd = pressure_psd(spectrum, centre, sound.pressure_reference, sound.loaded_sides)
    pd.DataFrame(
        {
            "center_hz": centre,
            "lower_hz": edges[:-1],
            "upper_hz": edges[1:],
            "band_spl_db": spectrum.band_spl,
            "surface_pressure_psd_pa2_hz": psd,
        }
    ).to_csv(spectrum_csv, index=False, float_format="%.7g")

    basis = read_basis(Path(modes))
    highest = float(field.wavenumber(study.response.frequency_hz[1], sound.speed_m_s))
    face = field.PanelQuadrature(
        basis.quadrature_position, basis.quadrature_weight, basis.shape_at_quadrature
    )
    diffuse = None
    if sound.field == "diffuse" or air_nc:
        diffuse = field.tabulate_diffuse(highest, face)
    if sound.field == "diffuse":
        table = diffuse
    elif sound.field == "uncorrelated":
        area = field.lumped_area(basis.vertex_position, basis.cells)
        uncorrelated = field.uncorrelated_modal_force(area, basis.shape_at_vertices)
        table = constant_table(highest, uncorrelated)
    elif sound.field == "uniform":
        table = constant_table(highest, field.uniform_modal_force(face))
    else:
        table = field.tabulate_plane_wave(highest, sound.incidence, sound.azimuth, face)
    write_tables(Path(modal_force_nc), {MODAL_FORCE: table}, {**stamp(study), "field": sound.field})
    if air_nc:
        air = {DIFFUSE: diffuse, ADDED_VOLUME: tabulate_added_mass(highest, face)}
        write_tables(Path(air_nc[0]), air, stamp(study))
