"""Mesh the panel, find its modes; write mesh.msh, modes.nc, modes.csv, modes.vtu, section.csv."""

import sys
from pathlib import Path

from pidpanel.panel import modes
from pidpanel.panel.basis_files import write_basis, write_shapes
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.panel.tables import mode_table, section_table
from pidpanel.stamp import stamp
from pidpanel.study import load_study

if __name__ == "__main__":
    study_path, *outputs = sys.argv[1:]
    modes_nc, modes_csv, modes_vtu, mesh_msh, section_csv = map(Path, outputs)
    study = load_study(study_path)
    studied = StudiedPanel(study.panel)
    mesh = studied.mesh(mesh_msh)
    plate = studied.plate(mesh)
    basis = modes.panel_basis(mesh, plate, modes.MODES_BEYOND * study.response.frequency_hz[1])
    write_basis(modes_nc, basis, stamp(study))
    write_shapes(modes_vtu, basis)
    mode_table(basis, studied.navier_size, studied.section).to_csv(
        modes_csv, index=False, float_format="%.8g"
    )
    section_table(studied.section, plate).to_csv(section_csv, index=False, float_format="%.8g")
