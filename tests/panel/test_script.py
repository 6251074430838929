"""The script of the stage, on a small study that needs no LIGGGHTS."""

import meshio
import numpy as np
import pandas as pd
import pytest
import xarray as xr

from pidpanel.panel.files import read_basis
from pidpanel.panel.mesh import read_mesh
from pidpanel.panel.navier import thin_plate_frequency
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import LEAST_MODES
from pidpanel.provenance.digests import stamp
from pidpanel.study import load_study
from tests.jobs import make_panel

STUDY = """
dampers: {law: {law: paper_corrected}}
panel:
  outline_m: [0.9, 0.6]
  section: {kind: thin, mass_per_area_kg_m2: 4.0, bending_stiffness_n_m: 3273.07}
  mesh: {elements: [18, 12]}
  patches: {P: {centre_m: [0.4, 0.3], size_m: [0.2, 0.2]}}
  points: {A: [0.4, 0.3]}
sound: {spectrum: smc_s_016_2014_min_third.csv}
response: {frequency_hz: [30, 1400]}
scenarios: {one: {title: "One", patch: [P], damper: law, fill_fraction: 0.5}}
"""


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("script")
    (folder / "small.yaml").write_text(STUDY)
    make_panel(folder / "small.yaml", folder)
    return folder


def test_modes_are_kept_to_twice_the_highest_frequency_and_are_naviers(built):
    modes = pd.read_csv(built / "modes.csv")
    m, n = np.meshgrid(range(1, 12), range(1, 12))
    exact = np.sort(thin_plate_frequency(m, n, (0.9, 0.6), ThinSection(3273.07, 4.0)).ravel())
    exact = exact[exact < 2800.0]
    assert len(exact) > LEAST_MODES
    # bicubic elements, 18 × 12 of them: 1e-3 at five half waves along each side
    np.testing.assert_allclose(modes["frequency_hz"], exact, rtol=1e-3)
    np.testing.assert_allclose(modes["navier_hz"], exact, rtol=1e-7)  # %.8g


def test_section_csv_holds_the_section_of_the_study_and_the_mass_of_the_panel(built):
    section = pd.read_csv(built / "section.csv").set_index(["quantity", "row", "column"])["value"]
    assert section["bending", 1, 1] == pytest.approx(3273.07)
    assert section["bending", 1, 2] == pytest.approx(0.3 * 3273.07)
    assert section["area", 0, 0] == pytest.approx(0.54)
    assert section["mass", 0, 0] == pytest.approx(4.0 * 0.54)


def test_basis_carries_the_study_and_is_what_the_pictures_show(built):
    study = load_study(built / "small.yaml")
    with xr.open_dataset(built / "modes.nc", engine="scipy") as dataset:
        assert dataset.attrs == stamp(study)
    basis = read_basis(built / "modes.nc")
    assert basis.patch_names == ("P",) and basis.point_names == ("A",)
    shapes = meshio.read(built / "modes.vtu").point_data
    assert len(shapes) == len(basis.natural_frequency)
    pictured = np.stack(list(shapes.values()), axis=1)
    # modes.nc holds them in single precision
    np.testing.assert_allclose(pictured, basis.shape_at_vertices, rtol=6e-8, atol=1e-37)
    mesh = read_mesh(built / "mesh.msh", basis.patch_names, {})
    np.testing.assert_array_equal(mesh.vertices, basis.vertex_position)
