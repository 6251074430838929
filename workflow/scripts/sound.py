"""Band levels and pressure PSD; modal force of the field: spectrum.csv, modal_force.nc."""

import sys
from pathlib import Path

import pandas as pd

from pidpanel.panel.basis_files import read_basis
from pidpanel.sound import field
from pidpanel.sound.field_files import write_modal_force
from pidpanel.sound.spectrum import pressure_psd
from pidpanel.sound.table import read_spl_table
from pidpanel.stamp import stamp
from pidpanel.study import load_study

if __name__ == "__main__":
    study_path, modes, spectrum_csv, modal_force_nc = sys.argv[1:]
    study = load_study(study_path)
    sound = study.sound
    spectrum = read_spl_table(sound.spectrum)
    if sound.oaspl_db is not None:
        spectrum = spectrum.at_oaspl(sound.oaspl_db)
    edges = spectrum.edge_frequency
    centre = spectrum.center_frequency
    pd.DataFrame(
        {
            "center_hz": centre,
            "lower_hz": edges[:-1],
            "upper_hz": edges[1:],
            "band_spl_db": spectrum.band_spl,
            "surface_pressure_psd_pa2_hz": pressure_psd(spectrum, centre, sound.pressure_reference),
        }
    ).to_csv(spectrum_csv, index=False, float_format="%.7g")

    basis = read_basis(Path(modes))
    highest = field.wavenumber(study.response.frequency_hz[1], sound.speed_m_s)
    if sound.field == "diffuse":
        quadrature = field.PanelQuadrature(
            basis.quadrature_position, basis.quadrature_weight, basis.shape_at_quadrature
        )
        table = field.tabulate_diffuse(float(highest), quadrature)
    else:
        area = field.lumped_area(basis.vertex_position, basis.cells)
        table = field.constant_table(
            float(highest), field.uncorrelated_modal_force(area, basis.shape_at_vertices)
        )
    write_modal_force(Path(modal_force_nc), table, {**stamp(study), "field": sound.field})
