"""Mesh the panel, find its modes; write mesh.msh, modes.nc, modes.csv, modes.vtu."""

import sys
from pathlib import Path

import pandas as pd

from pidpanel.panel import mesh, modes, navier, section, thin
from pidpanel.panel.basis_files import write_basis, write_shapes
from pidpanel.stamp import stamp
from pidpanel.study import load_study

MODES_BEYOND = 1.4
"""Modes are kept up to this times the highest frequency; residual vectors do the rest."""

if __name__ == "__main__":
    study_path, *outputs = sys.argv[1:]
    modes_nc, modes_csv, modes_vtu, mesh_msh = map(Path, outputs)
    study = load_study(study_path)
    panel = study.panel
    patches = {n: mesh.Rectangle(p.centre_m, p.size_m) for n, p in panel.patches.items()}
    points = dict(panel.points)
    if panel.mesh.kind == "quadrilaterals":
        grid = mesh.mesh_quadrilaterals(
            mesh_msh, panel.outline_m, panel.mesh.elements, patches, points
        )
    else:
        (a, b) = panel.outline_m
        outline = [(0.0, 0.0), (a, 0.0), (a, b), (0.0, b)]
        grid = mesh.mesh_triangles(mesh_msh, outline, panel.mesh.size_m, patches, points)
    section = section.ThinSection(
        panel.section.bending_stiffness_n_m,
        panel.section.mass_per_area_kg_m2,
        panel.section.poissons_ratio,
    )
    assembled = thin.assemble_thin_plate(grid, section)
    basis = modes.panel_basis(grid, assembled, MODES_BEYOND * study.response.frequency_hz[1])
    write_basis(modes_nc, basis, stamp(study))
    write_shapes(modes_vtu, basis)
    orders, share = navier.mode_orders(basis, panel.outline_m)
    closed_form = navier.thin_plate_frequency(
        orders[:, 0],
        orders[:, 1],
        panel.outline_m,
        section.bending_stiffness,
        section.mass_per_area,
    )
    count = len(orders)
    pd.DataFrame(
        {
            "mode": range(1, count + 1),
            "m": orders[:, 0],
            "n": orders[:, 1],
            "frequency_hz": basis.natural_frequency[:count],
            "navier_hz": closed_form,
            "modal_mass_kg": basis.modal_mass[:count],
            "share_of_sine": share,
        }
    ).to_csv(modes_csv, index=False, float_format="%.8g")
