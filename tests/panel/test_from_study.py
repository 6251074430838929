"""Truths of panels as a study writes them: what each key becomes, and what is refused."""

import copy
from pathlib import Path

import numpy as np
import pytest
import yaml

from pidpanel.check import checked_study
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.study import StudyError, load_study
from pidpanel.study.section import SandwichSectionInput

STUDIES = Path(__file__).parents[2] / "workflow" / "studies"


def variant(tmp_path, name, change):
    """A shipped study with one change, as a file beside its mesh."""
    values = yaml.safe_load((STUDIES / f"{name}.yaml").read_text())
    values = copy.deepcopy(values)
    change(values["panel"])
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(values, sort_keys=False, allow_unicode=True))
    (tmp_path / "bdf_panel.bdf").write_text((STUDIES / "bdf_panel.bdf").read_text())
    return path


def at(keys, value):
    def change(panel):
        *parents, last = keys.split(".")
        for key in parents:
            panel = panel[int(key) if key.isdigit() else key]
        panel[last] = value

    return change


@pytest.mark.parametrize("name", ["l_panel", "sandwich_hole_hinge", "bdf_panel"])
def test_the_shipped_panels_pass_every_check(name):
    checked_study(STUDIES / f"{name}.yaml")


def test_a_core_by_its_grade_has_the_makers_moduli():
    section = StudiedPanel(load_study(STUDIES / "sandwich_hole_hinge.yaml").panel).section
    # 27 and 13 ksi, 2.0 pcf
    assert section.core.shear_modulus_l == pytest.approx(27e3 * 6894.757, rel=3e-3)
    assert section.core.shear_modulus_w == pytest.approx(13e3 * 6894.757, rel=5e-3)
    assert section.core.density == pytest.approx(2.0 * 16.01846, rel=2e-3)
    assert len(section.top) == 3 and section.top[2].angle == pytest.approx(np.radians(-60))


@pytest.mark.parametrize(
    ("material", "youngs_modulus", "shear_modulus"),
    [
        # of Tsai and Hahn's own table of quasi-isotropic laminates
        ("T300/5208 carbon", 69.68, 26.88),
        ("AS/3501 carbon", 54.84, 21.35),
        ("Kevlar 49/epoxy", 29.02, 10.95),
        ("Scotchply 1002 glass", 18.96, 7.47),
        # 10.6, 10.0 and 10.4 Msi
        ("Al 2024-T3", 10.6 * 6.894757, 10.6 * 6.894757 / 2.66),
        ("Al 6061-T6", 10.0 * 6.894757, 10.0 * 6.894757 / 2.66),
        ("Al 7075-T6", 10.4 * 6.894757, 10.4 * 6.894757 / 2.66),
    ],
)
def test_faces_of_a_material_by_name_have_its_published_moduli(
    material, youngs_modulus, shear_modulus
):
    plies = [{"material": material, "thickness_mm": 0.1, "angle_deg": a} for a in (0, 45, -45, 90)]
    core = {"grade": "3/16-5056-0.0007", "thickness_mm": 20}
    values = {"kind": "sandwich", "faces": plies, "core": core}
    spec = SandwichSectionInput.model_validate(values)
    panel = load_study(STUDIES / "sandwich_hole_hinge.yaml").panel
    A = StudiedPanel(panel.model_copy(update={"section": spec})).section.abd[0] / 0.8e-3 / 1e9
    assert (A[0, 0] ** 2 - A[0, 1] ** 2) / A[0, 0] == pytest.approx(youngs_modulus, rel=1e-3)
    assert A[2, 2] == pytest.approx(shear_modulus, rel=1e-3)


def test_a_material_of_the_study_comes_before_one_of_the_table():
    own = {"Al 2024-T3": {"youngs_modulus_gpa": 1, "poissons_ratio": 0.3, "density_kg_m3": 100}}
    plies, core = [{"material": "Al 2024-T3", "thickness_mm": 1}], {"grade": "3/16-5056-0.0007"}
    values = {"kind": "sandwich", "faces": plies, "core": {**core, "thickness_mm": 20}}
    spec = SandwichSectionInput.model_validate({**values, "materials": own})
    assert spec.all_materials["Al 2024-T3"].density_kg_m3 == 100


@pytest.mark.parametrize(
    ("name", "keys", "value", "message"),
    [
        ("sandwich_hole_hinge", "section.core.grade", "3/16-5056-0.0008", "grade = 3/16-5056-0.0008: unknown grade; the nearest are 3/16-5056-0.0007"),
        ("sandwich_hole_hinge", "section.core.density_kg_m3", 32, "either grade, or density_kg_m3, shear_modulus_l_mpa"),
        ("sandwich_hole_hinge", "section.kind", "thick", "panel.section.kind = thick: must be 'thin', 'solid' or 'sandwich'"),
        ("sandwich_hole_hinge", "section.facs", [], "panel.section.facs = []: unknown key; did you mean faces?"),
        ("sandwich_hole_hinge", "section.faces.0.material", "foil", "material = foil: must be one of materials: tape"),
        ("sandwich_hole_hinge", "section.materials.tape", {"e1_gpa": 1, "density_kg_m3": 1600}, "either youngs_modulus_gpa and poissons_ratio, or e1_gpa"),
        ("sandwich_hole_hinge", "supports.points.hinge 1.at_m", [1.05, 0.65], "lies over hole 'cut-out'"),
        ("sandwich_hole_hinge", "supports.points.hinge 1.radius_m", 0.2, "'foot of hinge 1' = circle of radius"),
        ("sandwich_hole_hinge", "supports.points.hinge 1.grid", 7, "either at_m, or grid"),
        ("sandwich_hole_hinge", "masses.connector.at_m", [3, 3], "point 'connector' = (3, 3) m leaves the panel"),
        ("sandwich_hole_hinge", "masses.connector.to_m", [1, 1], "either at_m, or grid, or from_m and to_m"),
        ("sandwich_hole_hinge", "mesh", {"kind": "quadrilaterals"}, "mesh.kind = quadrilaterals: quadrilaterals do not allow an outline other than a whole rectangle; patches.centre"),
        ("sandwich_hole_hinge", "mesh.size_m", 0.2, "size_m: 0.2, corner_size_m: 0.005}: element edges of 0.2 m are too coarse for 2000 Hz, where half a bending wavelength is"),
        ("sandwich_hole_hinge", "corner_radius_m", 0.6, "corner radius 0.6 m: the edge from"),
        ("sandwich_hole_hinge", "holes.cut-out.size_m", [0.1, 0.1], "must have either centre_m and size_m, or centre_m and diameter_m, or corners_m"),
        ("l_panel", "outline_m", [[0, 0], [1, 1], [1, 0], [0, 2]], "outline crosses itself"),
        ("l_panel", "supports", {"outline": "free", "edges": [{"from_m": [0, 0], "to_m": [9, 0], "kind": "clamped"}]}, "'supports.edges 1 to_m' = (9, 0) m leaves the panel"),
        ("l_panel", "patches.arm.group", "2", ", or corners_m, or group"),
        ("l_panel", "points.A", {"grid": 3}, "points.A.grid = 3: only allowed with mesh: {kind: file}"),
        ("l_panel", "points.arm", [0.3, 0.3], "'arm' names both a patch and a point"),
        ("bdf_panel", "outline_m", [1, 1], "outline_m = [1, 1]: not allowed with mesh: {kind: file}, which has its own"),
        ("bdf_panel", "mesh.file", "none.bdf", "panel.mesh.file = none.bdf: no such file"),
        ("bdf_panel", "mesh.file", "panel.step", "file = panel.step: must end in one of .bdf, .dat, .nas, .fem, .inp"),
        ("bdf_panel", "points.left.grid", 99, "no node 99; it has"),
        ("bdf_panel", "patches.side.centre_m", [1.1, 0.7], "cover 0 m² of its 0.04 m²"),
    ],
)  # fmt: skip
def test_a_panel_that_cannot_be_is_refused_in_one_line(tmp_path, name, keys, value, message):
    with pytest.raises(StudyError) as caught:
        checked_study(variant(tmp_path, name, at(keys, value)))
    text = str(caught.value)
    assert message in text, text
    assert "\n" not in text and "mine.yaml" in text
