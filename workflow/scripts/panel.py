"""Mesh and modes of the panel of a study: modes.nc, modes.csv, modes.vtu, mesh.msh, section.csv."""

import sys
from collections.abc import Sequence
from pathlib import Path

from pidpanel.panel import basis_files, from_study
from pidpanel.stamp import stamp
from pidpanel.study import load_study


def main(arguments: Sequence[str]) -> None:
    """Take the study and the files to write, in the order above."""
    study_file, modes_nc, modes_csv, modes_vtu, mesh_msh, section_csv = map(Path, arguments)
    study = load_study(study_file)
    panel = from_study.StudiedPanel(study.panel)
    basis = panel.basis(mesh_msh, study.response.frequency_hz[1])
    basis_files.write_basis(modes_nc, basis, stamp(study))
    basis_files.write_shapes(modes_vtu, basis)
    panel.mode_table(basis).to_csv(modes_csv, index=False, float_format="%.8g")
    panel.section_table(basis).to_csv(section_csv, index=False, float_format="%.8g")


if __name__ == "__main__":
    main(sys.argv[1:])
