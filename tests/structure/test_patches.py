"""Patches of structures: their motion along the surface, their normals, what is refused of them."""

import json
from dataclasses import replace
from importlib import resources
from unittest import mock

import numpy as np
import pandas as pd
import pytest
from browser import CHROMIUM, Browser

from pidpanel import Model, StudyError
from pidpanel.panel.files import read_basis
from pidpanel.report.html import Picture
from pidpanel.report.panel_section import TURNED_CELLS, panel_section, turned_surface
from pidpanel.report.templates import environment
from pidpanel.structure.from_study import structure_of
from pidpanel.structure.surface import Surface, tangential_share, view_axes
from tests.page_reader import blocks_of
from tests.structures import AXES, COMMON, CURVED, NORMAL, in_space

SQUARE = Surface(in_space([[0, 0], [1, 0], [1, 1], [0, 1]]), np.array([[0, 1, 2, 3]]))


def test_the_tangential_share_is_that_of_modes_of_equal_energy():
    across, along = np.outer(np.ones(4), NORMAL), np.outer(np.ones(4), AXES[0])
    motion = np.stack([across, 2 * along, 0.6 * across + 0.8 * along], axis=2)
    inside = np.array([0])

    def share(modes, mass):
        return tangential_share(SQUARE, inside, motion[:, :, modes], np.array(mass))

    assert share([0], [3.0]) == pytest.approx(0, abs=1e-12)
    assert share([1], [3.0]) == pytest.approx(1)
    assert share([2], [3.0]) == pytest.approx(0.64)
    # squares over modal masses: 1/2 across, 4/8 along
    assert share([0, 1], [2.0, 8.0]) == pytest.approx(0.5)


def arch(**patch):
    structure = {**CURVED, "patches": {"P": {**CURVED["patches"]["P"], **patch}}}
    bed = {
        "particles": {"diameter_mm": 2, "density_kg_m3": 1190, "restitution": 0.8, "friction": 0.3},
        "cell": {"across_flats_mm": 6.35, "depth_mm": 12}, "model": "atlas",
        "gravity_direction": [0, 0.6, -0.8],
    }  # fmt: skip
    scenario = {"one": {"patch": "P", "fill_fraction": 0.5}}
    return {
        **COMMON, "name": "arch", "structure": structure, "dampers": {"bed": bed},
        "response": {"frequency_hz": [30, 150]}, "scenarios": scenario,
    }  # fmt: skip


@pytest.fixture(scope="module")
def arch_section():
    """A curved shell's basis and its section of the page."""
    model = Model(arch())
    basis = read_basis(model._stages.files("panel").modes)
    modes = pd.DataFrame({"mode": [1], "frequency_hz": [50.0], "modal_mass_kg": [1.0]})
    return basis, panel_section(basis, modes, pd.DataFrame(), model.study, basis)


def test_the_page_has_normal_angle_and_share_of_each_patch(arch_section):
    basis, section = arch_section
    assert 0 < basis.tangential_share[0] < 0.2
    table = next(block for block in blocks_of(section) if "normal" in str(vars(block)))
    assert table.rows == [["P", "0, 0, 1", "37°", table.rows[0][-1]]]  # acos 0.8
    assert 0 < float(table.rows[0][-1].split()[0]) < 20


def test_a_surface_in_space_has_its_patches_in_the_view_that_turns(arch_section):
    basis, _ = arch_section
    turned = json.loads(turned_surface(basis))
    assert np.linalg.norm(turned["vertices"], axis=1).max() == pytest.approx(0.5, abs=1e-4)
    (own,) = {turned["colour"][k] for k in np.flatnonzero(basis.cell_in_patch[0])}
    assert turned["colour"].count(own) == basis.cell_in_patch[0].sum()
    assert turned["cells"] == basis.cells.tolist() and list(turned["points"]) == ["mid"]
    many = np.tile(basis.cells, (1 + TURNED_CELLS // len(basis.cells), 1))
    assert turned_surface(replace(basis, cells=many)) is None


@pytest.mark.skipif(CHROMIUM is None, reason="Chromium is not installed")
def test_a_key_turns_the_surface(arch_section, tmp_path):
    show = environment().get_template("macros.html").module.show
    with mock.patch.object(Picture, "image", b""):
        text = show(arch_section[1].blocks[0])
    script = (resources.files("pidpanel.report") / "pages" / "page.js").read_text()
    page = tmp_path / "page.html"
    page.write_text(f"<!DOCTYPE html><meta charset='utf-8'>{text}<script>{script}</script>")
    image = "document.querySelector('.turned canvas').toDataURL()"
    press = (
        "document.querySelector('.turned').dispatchEvent(new KeyboardEvent('keydown', {key: '%s'}))"
    )
    with Browser(800) as browser:
        browser.open(page)
        first = browser.run(image)
        browser.run(press % "ArrowLeft")
        assert browser.run(image) != first
        browser.run(press % "ArrowRight")
        assert browser.run(image) == first
        assert browser.complaints() == []


@pytest.mark.parametrize("normal", [[1, 0, 0], [0, 0, -1]])
def test_a_normal_that_is_none_is_refused(normal):
    with pytest.raises(StudyError, match=r"structure\.patches\.P\.normal.*within 60°"):
        Model(arch(normal=normal))


@pytest.mark.parametrize("along", [[1, 0, 0], [1, 1, 0]])
def test_a_polygon_that_is_a_line_in_its_projection_is_refused(along):
    values = arch()
    corners = [[0.2, -0.1, 1], [0.4, -0.1, 1], [0.4, 0.1, 1]]
    values["structure"]["patches"]["P"] = {"corners_m": corners, "along": along}
    with pytest.raises(StudyError, match=r"structure\.patches\.P\.corners_m.*no line"):
        Model(values)


ELSEWHERE = {"from_m": [5, 5, 5], "to_m": [6, 6, 6]}
BLADE = {
    "width_mm": 4, "height_mm": 20, "offset_mm": 11.5, "youngs_modulus_gpa": 70,
    "density_kg_m3": 2700,
}  # fmt: skip


@pytest.mark.parametrize(
    ("attached", "key"),
    [
        ({"supports": {"x": {"where": ELSEWHERE}}}, "supports.x"),
        ({"feet": {"x": {"where": ELSEWHERE, "centre_m": [5, 5, 5]}}}, "feet.x"),
        ({"masses": {"x": {"at_m": [0.4, 0, 2], "mass_kg": 0.1}}}, "masses.x"),
        (
            {"stiffeners": {"x": {"from_m": [0, 0, 1], "to_m": [1.2, 0, 1], **BLADE}}},
            "stiffeners.x",
        ),
    ],
)
def test_what_is_attached_off_the_surface_is_refused(attached, key):
    values = arch()
    values["structure"] = {**values["structure"], "shell": {**CURVED["shell"], **attached}}
    with pytest.raises(StudyError, match=rf"structure\.shell\.{key}"):
        Model(values)


def test_a_panel_whose_corners_are_in_no_plane_is_refused():
    values = arch()
    corners = {"warped": [[0, 0, 0], [1, 0, 0], [1, 1, 0.2], [0, 1, 0]]}
    form = {"kind": "panels", "corners_m": corners}
    values["structure"] = {**values["structure"], "shell": {**CURVED["shell"], "form": form}}
    with pytest.raises(StudyError, match=r"structure\.shell\.form.*one plane"):
        Model(values)


def test_an_axis_along_the_normal_of_a_wall_is_refused():
    values = arch()
    corners = {
        "floor": [[0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
        "wall": [[1, 0, 1], [1, 1, 1], [1, 1, 1.5], [1, 0, 1.5]],
    }
    sandwich = {
        "kind": "sandwich", "core": {"thickness_mm": 20, "grade": "1/4-5056-0.0007"},
        "faces": [{"material": "skin", "thickness_mm": 0.3}],
        "materials": {
            "skin": {"youngs_modulus_gpa": 70, "poissons_ratio": 0.3, "density_kg_m3": 2700}
        },
    }  # fmt: skip
    form = {"kind": "panels", "corners_m": corners}
    shell = {**CURVED["shell"], "form": form, "section": sandwich}
    values["structure"] = {**values["structure"], "shell": shell}
    with pytest.raises(StudyError, match=r"structure\.shell.*axis"):
        Model(values)


def test_the_view_of_a_rectangle_is_along_its_sides():
    place = in_space([[0, 0], [1.5, 0], [1.5, 1], [0, 1]])
    drawn = place @ view_axes(Surface(place, np.array([[0, 1, 2, 3]])))
    assert sorted(np.ptp(drawn, axis=0)) == pytest.approx([1.0, 1.5])


@pytest.mark.parametrize("turn", [0.0, 0.1])
def test_the_view_of_a_coarse_disc_is_along_x(turn):
    angle = turn + 2 * np.pi * np.arange(20) / 20
    rim = np.stack([np.cos(angle), np.sin(angle), np.zeros(20)], axis=1)
    cells = np.array([[20, k, (k + 1) % 20] for k in range(20)])
    axes = view_axes(Surface(np.vstack([rim, np.zeros(3)]), cells))
    np.testing.assert_allclose(axes, np.eye(3)[:, :2], atol=1e-12)


def test_normals_of_a_wide_patch_spread():
    structure = structure_of(Model(arch(radius_m=0.3)).study.panel)
    # to the middles of elements, arcs within 0.3 m of the crown of a cylinder of 1 m
    assert 10 < structure.normal_spread("P") < np.degrees(0.3)
