"""What the check of a study accepts, the panel stage carries out; what not, one line refuses."""

import numpy as np
import pytest

from pidpanel.panel.basis import basis_of
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.panel.modes import first_modes, normal_modes, quadratic_form
from pidpanel.panel.point_supports import added_compliance
from pidpanel.panel.resolution import FOOT_SHIFT_OF_ANY
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import MODES_BEYOND, panel_shapes
from pidpanel.response.refinement import MARGIN, mode_shifts
from pidpanel.solve.mesh_error import point_shifts
from pidpanel.solve.sharpness import LoadedModes
from pidpanel.study.panel import Panel

THIN = {"mass_per_area_kg_m2": 4.0, "bending_stiffness_n_m": 3273.07}
SOLID = {
    "kind": "solid", "youngs_modulus_gpa": 70, "poissons_ratio": 0.33, "density_kg_m3": 2700,
    "thickness_mm": 5,
}  # fmt: skip
SANDWICH = {
    "kind": "sandwich",
    "materials": {"tape": {"e1_gpa": 280, "e2_gpa": 6.5, "g12_gpa": 4.5, "nu12": 0.3, "density_kg_m3": 1600}},
    "faces": [{"material": "tape", "thickness_mm": 0.1, "angle_deg": a} for a in (0, 60, -60)],
    "core": {"grade": "3/16-5056-0.0007", "thickness_mm": 24.4, "ribbon_deg": 0},
}  # fmt: skip
L = [[0, 0], [1, 0], [1, 0.5], [0.5, 0.5], [0.5, 1], [0, 1]]
NOTCHED = [[0, 0], [0.4, 0], [0.4, 0.1], [0.6, 0.1], [0.6, 0], [1, 0], [1, 1], [0, 1]]
STAR = [[0, 0], [0.5, 0.2], [1, 0], [0.8, 0.5], [1, 1], [0.5, 0.8], [0, 1], [0.2, 0.5]]
SKEW = [[0.1, 0.03], [1.13, 0.21], [1.57, 0.87], [0.5, 0.8]]
SQUARE = {"h": {"centre_m": [0.5, 0.5], "size_m": [0.2, 0.2]}}


def triangles(size, **more):
    return {"kind": "triangles", "size_m": size, **more}


def quadrilaterals(*elements):
    return {"kind": "quadrilaterals", "elements": elements}


def patch(x, y, a, b):
    return {"P": {"centre_m": [x, y], "size_m": [a, b]}}


def held(*points, outline="free", **more):
    return {"outline": outline, "points": dict(zip("hijk", points, strict=False)), **more}


def foot(x, y, radius, kind="hold_down"):
    return {"at_m": [x, y], "kind": kind, "radius_m": radius}


def edge(start, end):
    return held(edges=[{"from_m": start, "to_m": end, "kind": "clamped"}])


def spring(x, y, stiffness):
    return {"at_m": [x, y], "kind": "spring", "stiffness_n_m": stiffness}


def of(outline, section, mesh, frequency, supports="simply_supported", at=(0, 0), **more):
    panel = {"outline_m": outline, "section": section, "mesh": mesh, "supports": supports}
    # resonances so wide that the meshes, coarse on purpose, are fine enough
    panel["damping_ratio"] = 0.05
    return {**panel, "patches": {}, "points": {"c": list(at)}, **more}, frequency


UNIT = (1, 1)
# radius of a foot, 24 pieces with the area of the disc, that reaches an edge 0.1 m away
TOUCHING = 0.1 * np.sqrt(np.sin(np.pi / 12) / (np.pi / 12))
ACCEPTED = {
    "slender, thin, quadrilaterals": of([3, 0.05], THIN, quadrilaterals(60, 2), 2000),
    "slender, sandwich, free": of([3, 0.05], SANDWICH, triangles(0.1), 500, "free"),
    "needle, solid, clamped": of([[0, 0], [0.5, 0], [0.5, 0.01]], SOLID, triangles(0.1), 500, "clamped"),
    "5 kHz, thin, quadrilaterals": of([0.6, 0.4], THIN, quadrilaterals(10, 7), 5000),
    "stiff, thin, 2 × 2": of([0.3, 0.2], THIN, quadrilaterals(2, 2), 200, patches=patch(0.15, 0.1, 0.3, 0.2)),
    "stiff, solid, element longer than the panel": of([0.3, 0.2], {**SOLID, "thickness_mm": 20}, triangles(0.4), 200, "clamped"),
    "millimetres": of([0.03, 0.02], SOLID, triangles(0.005), 5000),
    "far from the origin": of([[98, 98], [99, 98], [99, 99], [98, 99]], SANDWICH, triangles(0.1), 500, at=(98, 98), patches=patch(98.5, 98.5, 0.2, 0.2)),
    "star, free": of(STAR, SANDWICH, triangles(0.1, corner_size_m=0.02), 500, "free"),
    "hardly more coordinates than modes, free": of(UNIT, THIN, quadrilaterals(8, 8), 500, "free", patches=patch(0.5, 0.5, 0.25, 0.25)),
    "thick": of(UNIT, {**SOLID, "thickness_mm": 500}, triangles(0.2), 2000),
    "round hole, clamped": of(UNIT, SANDWICH, triangles(0.1), 1000, {"outline": "free", "holes": "clamped"}, holes={"h": {"centre_m": [0.5, 0.5], "diameter_m": 0.3}}),
    "rigid spring": of(UNIT, THIN, triangles(0.4), 200, held(spring(0.5, 0.5, 1e12))),
    "heavy mass": of(UNIT, THIN, triangles(0.4), 200, masses={"m": {"at_m": [0.5, 0.5], "mass_kg": 2000}}),
    "line of mass along an oblique edge": of(SKEW, SANDWICH, triangles(0.2), 100, at=SKEW[0], masses={"m": {"from_m": SKEW[1], "to_m": SKEW[2], "mass_kg": 1}}),
    "line of mass without length": of(UNIT, SANDWICH, triangles(0.2), 200, masses={"m": {"from_m": [0.5, 0.5], "to_m": [0.5, 0.5], "mass_kg": 1}}),
    "foot near a clamped edge": of(UNIT, SANDWICH, triangles(0.2), 200, held(foot(0.5, 0.06, 0.05), outline="clamped")),
    "hold-down on a clamped edge": of(UNIT, SANDWICH, triangles(0.2), 200, held({"at_m": [0.5, 0], "kind": "hold_down"}, outline="clamped")),
    "two supports at one place": of(UNIT, SANDWICH, triangles(0.2), 200, held({"at_m": [0.5, 0.5], "kind": "hold_down"}, {"at_m": [0.5, 0.5], "kind": "hinge"})),
    "edge of a hole": of(UNIT, SANDWICH, triangles(0.1, corner_size_m=0.02), 300, edge([0.4, 0.4], [0.6, 0.4]), holes=SQUARE),
    "patch of a millimetre": of(UNIT, SANDWICH, triangles(0.1), 500, patches=patch(0.5, 0.5, 1e-3, 1e-3)),
    "points all but in one place": of(UNIT, SANDWICH, triangles(0.1), 500, points={"c": [0.3, 0.3], "d": [0.30000001, 0.3], "e": [0.3, 0.3]}),
}  # fmt: skip

REFUSED = {
    "feet that meet": (of(UNIT, SANDWICH, triangles(0.2), 200, held(foot(0.5, 0.5, 0.1), foot(0.6, 0.5, 0.1))), "'foot of h' meets the support 'i'"),
    "a hinge in a foot": (of(UNIT, THIN, triangles(0.2), 200, held({"at_m": [0.5, 0.5], "kind": "hinge"}, foot(0.5, 0.5, 0.1))), "'foot of i' meets the support 'h'"),
    "a foot on a clamped part of the edge": (of(UNIT, SANDWICH, triangles(0.2), 200, edge([0, 0], [1, 0]) | {"points": {"h": foot(0.5, 0.1, 0.1 / 1.0057)}}), "'foot of h'"),
    "an edge across the panel": (of(UNIT, THIN, triangles(0.3), 500, edge([0, 0], [1, 1])), "the boundary does not lead straight to it"),
    "an edge round a corner": (of(UNIT, THIN, quadrilaterals(10, 10), 500, edge([0.5, 0], [1, 0.5])), "'supports.edges 1 to_m' = (1, 0.5) m"),
    "an edge without length": (of(UNIT, SANDWICH, triangles(0.1), 500, edge([0.5, 0], [0.5, 0])), "the boundary does not lead straight to it"),
    "an edge across a notch": (of(NOTCHED, SANDWICH, triangles(0.1), 300, edge([0, 0], [1, 0])), "the boundary does not lead straight to it"),
    "a line of mass past a corner": (of(L, THIN, triangles(0.2), 200, masses={"m": {"from_m": [0.9, 0.4], "to_m": [0.4, 0.9], "mass_kg": 1}}), "point 'm to_m' = (0.4, 0.9) m: the line to it"),
    "a line of mass over a hole": (of(UNIT, SANDWICH, triangles(0.1), 300, holes=SQUARE, masses={"m": {"from_m": [0.1, 0.5], "to_m": [0.9, 0.5], "mass_kg": 1}}), "leaves the panel"),
    "a mass beside the panel": (of(UNIT, THIN, quadrilaterals(8, 8), 200, masses={"m": {"at_m": [1.1, 1], "mass_kg": 1}}), "point 'm' = (1.1, 1) m leaves the panel"),
    "a spring beside the panel": (of(UNIT, THIN, quadrilaterals(8, 8), 200, held(spring(1.5, 0.5, 1e5))), "point 'support h' = (1.5, 0.5) m leaves the panel"),
    "a spring in a hole": (of(UNIT, SANDWICH, triangles(0.1), 200, held(spring(0.5, 0.5, 1e5)), holes=SQUARE), "point 'support h'"),
}  # fmt: skip


def basis_for(panel, frequency, folder):
    """The basis of a response up to a frequency [Hz]."""
    mesh = panel.mesh(folder / "panel.msh")
    plate = panel.plate(mesh)
    return basis_of(mesh, plate, panel_shapes(plate, MODES_BEYOND * frequency))


def carried_out(panel, frequency, folder):
    """The basis, after the check."""
    panel.check(frequency)
    basis = basis_for(panel, frequency, folder)
    for value in (basis.natural_frequency, basis.modal_mass, basis.shape_at_vertices):
        assert np.isfinite(value).all()
    assert (basis.natural_frequency >= 0).all() and (basis.modal_mass > 0).all()
    assert (~basis.is_residual).any() and basis.natural_frequency.max() > 0
    return basis


@pytest.mark.slow
@pytest.mark.parametrize("name", ACCEPTED)
def test_an_odd_panel_that_is_accepted_is_carried_out(tmp_path, name):
    panel, frequency = ACCEPTED[name]
    basis = carried_out(StudiedPanel(Panel(**panel)), frequency, tmp_path)
    for overlap in basis.patch_overlap:
        assert np.linalg.eigvalsh(overlap)[-1] > 0


@pytest.mark.slow
@pytest.mark.parametrize("name", REFUSED)
def test_an_odd_panel_that_the_stage_cannot_carry_out_is_refused_in_one_line(tmp_path, name):
    (panel, frequency), message = REFUSED[name]
    studied = StudiedPanel(Panel(**panel))
    with pytest.raises(ValueError) as caught:
        studied.check(frequency)
    assert message in str(caught.value) and "\n" not in str(caught.value)
    with pytest.raises(ValueError):
        basis_for(studied, frequency, tmp_path)


PARTS = held(
    edges=[
        {"from_m": [0.2, 0], "to_m": [0.6, 0], "kind": "clamped"},
        {"from_m": [0.4, 0.9], "to_m": [0.8, 0.9], "kind": "clamped"},
    ]
)
FEET = ((0.1, 0.1), (1.1, 0.2), (0.25, 0.8))


@pytest.mark.parametrize(
    ("supports", "frequencies", "tolerance"),
    [
        # elements of 5 µm at the ends of the parts
        (PARTS, [38.658, 70.578, 95.890, 131.114], 3e-4),
        # elements of 3 cm
        (held(*({"at_m": at, "kind": "hinge"} for at in FEET)), [27.461, 50.363, 92.546], 3e-5),
    ],
    ids=["parts clamped", "hinges"],
)
def test_modes_of_a_thin_plate_do_not_hang_on_elements_beside_its_supports(
    tmp_path, supports, frequencies, tolerance
):
    panel, _ = of(
        [1.2, 0.9], THIN, triangles(0.19), 500, supports, patches=patch(0.7, 0.4, 0.2, 0.2)
    )
    found = basis_for(StudiedPanel(Panel(**panel)), 200, tmp_path).natural_frequency
    elastic = found[found > 1][: len(frequencies)]
    np.testing.assert_allclose(elastic, frequencies, rtol=tolerance)


def test_the_stated_shift_of_a_thin_plate_contains_that_of_feet():
    panel, _ = of([1.2, 0.9], THIN, triangles(0.19), 500, held(*(foot(*at, 0.03) for at in FEET)))
    shift = StudiedPanel(Panel(**panel)).wave_shift(1e-3, 100.0, 0.0)
    assert shift == pytest.approx(0.1 * FOOT_SHIFT_OF_ANY, abs=1e-6)


@pytest.mark.parametrize(("count", "first"), [(1, 41.268), (4, 39.345)])
def test_the_stated_shift_of_rectangles_contains_that_at_the_ends_of_clamped_parts(count, first):
    # 38.658 Hz as above
    grid = quadrilaterals(12 * count, 9 * count)
    panel = Panel(**of([1.2, 0.9], THIN, grid, 500, PARTS)[0])
    shift = StudiedPanel(panel).wave_shift(0.1 / count, 1.0, 0.0)
    assert 1 < shift / (first / 38.658 - 1) < 1.2
    whole = panel.model_copy(
        update={
            "supports": Panel(**of([1.2, 0.9], THIN, grid, 500, edge([0, 0], [1.2, 0]))[0]).supports
        }
    )
    assert StudiedPanel(whole).wave_shift(0.1, 1.0, 0.0) < 1e-6
    refined = panel.model_copy(
        update={"mesh": panel.mesh.model_copy(update={"kind": "triangles", "size_m": 0.1})}
    )
    # triangles shrink towards the ends: 2e-4 are left
    assert 2e-4 < StudiedPanel(refined).wave_shift(0.1, 1.0, 0.0) < 4e-4


def grid(nx, ny, a, b):
    """Vertices and triangles of a rectangle."""
    x, y = np.meshgrid(np.linspace(0, a, nx + 1), np.linspace(0, b, ny + 1))
    corner = (np.arange(ny)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    right, up = corner + 1, corner + nx + 1
    cells = [[corner, right, up + 1], [corner, up + 1, up]]
    return np.column_stack([x.ravel(), y.ravel()]), np.vstack([np.column_stack(c) for c in cells])


def bulk_data(path, vertices, cells):
    lines = [f"GRID,{k},,{x:.9g},{y:.9g},0." for k, (x, y) in enumerate(vertices, 1)]
    lines += [
        f"CTRIA3,{k},{1 + k % 2},{a},{b},{c}" for k, (a, b, c) in enumerate((cells + 1).tolist(), 1)
    ]
    path.write_text("\n".join(lines) + "\n")


def given(section, supports="simply_supported", **more):
    return {
        "section": section,
        "supports": supports,
        "patches": {},
        "points": {"c": [0, 0]},
        **more,
    }


ONE, STRIP, PLATE = (1, 1, 0.3, 0.2), (20, 1, 2, 0.05), (12, 8, 0.6, 0.4)
GIVEN = {
    "two elements, thin": (ONE, given(THIN, "free"), ""),
    "two elements, sandwich, clamped": (ONE, given(SANDWICH, "clamped"), "every vertex is on a support"),
    "a strip, free": (STRIP, given(SANDWICH, "free", patches={"P": {"group": 1}}), ""),
    "a strip, supported": (STRIP, given(SOLID), "every vertex is on a support"),
    "a foot smaller than its elements": (PLATE, given(SANDWICH, held(foot(0.3, 0.2, 0.01))), "'foot of h' of radius 0.01 m about (0.3, 0.2) m: no element"),
    "a foot at a clamped edge": (PLATE, given(SANDWICH, held(foot(0.05, 0.2, 0.06), outline="clamped")), "'foot of h' meets a supported edge"),
    "feet that meet": (PLATE, given(SANDWICH, held(foot(0.3, 0.2, 0.06), foot(0.4, 0.2, 0.06))), "'foot of h' meets the support 'i'"),
    "a mass beside the panel": (PLATE, given(SANDWICH, masses={"m": {"at_m": [0.7, 0.2], "mass_kg": 1}}), "point 'm' = (0.7, 0.2) m leaves the panel"),
    "an edge across the panel": (PLATE, given(SANDWICH, edge([0.3, 0], [0.3, 0.4])), "the boundary does not lead straight to it"),
    "an edge that ends between nodes": (PLATE, given(SANDWICH, edge([0, 0], [0.33, 0])), "no node is there"),
}  # fmt: skip


@pytest.mark.parametrize("name", GIVEN)
def test_an_odd_mesh_of_a_file_is_carried_out_or_refused_in_one_line(tmp_path, name):
    mesh, panel, message = GIVEN[name]
    bulk_data(tmp_path / "panel.bdf", *grid(*mesh))
    file = {"kind": "file", "file": tmp_path / "panel.bdf"}
    studied = StudiedPanel(Panel(**panel, mesh=file))
    if not message:
        carried_out(studied, 100.0, tmp_path)
        return
    with pytest.raises(ValueError) as caught:
        studied.check(100.0)
    assert message in str(caught.value) and "\n" not in str(caught.value)
    with pytest.raises(ValueError):
        basis_for(studied, 100.0, tmp_path)


def first_frequencies(panel, tmp_path):
    studied = StudiedPanel(Panel(**panel))
    found = first_modes(studied.plate(studied.mesh(tmp_path / "panel.msh")), 6)[1]
    return studied, found[found > 1][:3]


def of_file(path, section, count, supports, **more):
    """Squares of 10 cm over a count, each cut in two, on 1.2 m × 0.9 m."""
    bulk_data(path, *grid(12 * count, 9 * count, 1.2, 0.9))
    return given(section, supports, mesh={"kind": "file", "file": path}, **more)


@pytest.mark.parametrize(
    ("count", "section", "converged"),
    [(1, THIN, [38.66, 70.58, 95.89]), (2, SANDWICH, [91.99, 164.29, 218.06])],
)
def test_the_stated_shift_of_a_file_contains_that_at_the_ends_of_clamped_parts(
    tmp_path, section, converged, count
):
    # 4 to 7 % with 10 cm, half of it with 5 cm
    panel = of_file(tmp_path / "panel.bdf", section, count, PARTS)
    studied, found = first_frequencies(panel, tmp_path)
    stated = studied.wave_shift(0.12 / count, float(found[0]), 0.0)
    assert 1 < stated / np.max(found / converged - 1) < 3
    assert studied.cause_of_shift(0.12 / count, float(found[0])) == "ends"


INSIDE, EDGES = ((0.1, 0.1), (1.1, 0.2), (0.3, 0.8)), ((0.6, 0), (1.2, 0.5), (0.3, 0.9))
AT_POINTS = {
    "thin, hold-downs at edges": (THIN, held(*(foot(*at, 0) for at in EDGES)), {}, 0.7, 1),
    "sandwich, hinges at edges": (SANDWICH, held(*(foot(*at, 0, "hinge") for at in EDGES)), {}, 0.9, 2),
    "sandwich, springs": (SANDWICH, held(*(spring(*at, 1e6) for at in INSIDE)), {}, 0.9, 2),
    "sandwich, masses": (SANDWICH, "simply_supported", {str(at): at for at in INSIDE}, 0.9, 1),
}  # fmt: skip


@pytest.mark.parametrize("name", AT_POINTS)
def test_elements_of_half_the_size_lower_modes_as_stated_for_single_points(tmp_path, name):
    section, supports, at, least, coarsest = AT_POINTS[name]
    masses = {f"m{k}": {"at_m": place, "mass_kg": 2.0} for k, place in enumerate(at.values())}
    found = []
    for count in (coarsest, 2 * coarsest):
        panel = of_file(tmp_path / f"{count}.bdf", section, count, supports, masses=masses)
        studied = StudiedPanel(Panel(**panel))
        studied.check(20.0)
        plate = studied.plate(studied.mesh(tmp_path / "panel.msh"))
        frequency, modes = normal_modes(plate, 300.0 if section is SANDWICH else 150.0)
        elastic = frequency > 1
        reactions = np.array([rows @ modes[:, elastic] for rows in plate.reactions])
        reactions /= np.sqrt(quadratic_form(plate.mass, modes[:, elastic]))
        omega = 2 * np.pi * frequency[elastic]
        found.append((omega[:3], point_shifts(reactions, omega)[:3]))
    (coarse, shift), (fine, _) = found
    change = coarse / fine - 1
    assert np.all(change < 1.15 * shift) and np.all(change > least * shift)


def test_the_motion_near_a_single_support_changes_with_the_logarithm_of_its_foot():
    # w ~ ln(ρ/a) below the extent of 0.5 m, a tenth of elements of 6 cm, and then half of it
    panel, _ = of([1, 1], SANDWICH, triangles(0.06), 500,
                  held(foot(0.5, 0.5, 0), foot(0.9, 0.9, 0, "hinge"), foot(0.1, 0.9, 0.02)),
                  points={"near": [0.5, 0.56], "far": [0.5, 0.999], "foot": [0.1, 0.93]})  # fmt: skip
    change = StudiedPanel(Panel(**panel)).point_refinement_error(500.0)
    before, after = (np.log(0.06 / foot) / np.log(0.5 / foot) for foot in (6e-3, 3e-3))
    assert change[0] == pytest.approx(after / before - 1, abs=0.03)
    assert change[1] < 0.03 and change[2] < 0.03
    masses = {
        "m": {"at_m": [0.5, 0.5], "mass_kg": 3.0},
        "light": {"at_m": [0.1, 0.9], "mass_kg": 1e-3},
    }
    loaded = StudiedPanel(Panel(**{**panel, "supports": "free", "masses": masses}))
    heavy, light = loaded.point_refinement_error(500.0)[[0, 2]]
    both = StudiedPanel(Panel(**{**panel, "masses": masses})).point_refinement_error(500.0)
    assert both[0] == change[0]
    assert 0.5 * change[0] < heavy < change[0] and light < 0.01
    thin = {**panel, "section": THIN}
    thin["supports"] = held(foot(0.5, 0.5, 0, "hinge"))
    assert not StudiedPanel(Panel(**thin)).point_refinement_error(500.0).any()


def test_a_force_on_a_thin_plate_needs_no_foot():
    assert added_compliance(ThinSection(3273.07, 4.0), 1.0)[0] == 0.0


@pytest.mark.parametrize(("section", "kind"), [(SANDWICH, "hold_down"), (SOLID, "hinge")])
def test_the_stated_shift_of_a_file_contains_that_of_feet_of_whole_elements(
    tmp_path, section, kind
):
    # 4, 6 and 2 % beside round feet
    feet = held(*(foot(x, y, 0.045, kind) for x, y in ((0.15, 0.1), (1.05, 0.2), (0.3, 0.75))))
    studied, found = first_frequencies(of_file(tmp_path / "panel.bdf", section, 2, feet), tmp_path)
    studied.check(20.0)
    round_feet, _ = of([1.2, 0.9], section, triangles(0.08), 300, feet)
    rounded, right = first_frequencies(round_feet, tmp_path)
    shift = np.max(found / right - 1)
    assert 0.01 < shift < MARGIN * studied.wave_shift(1e-3, 1.0, 0.0) < 5 * shift
    assert studied.cause_of_shift(1e-3, 1.0) == "feet"
    assert rounded.wave_shift(1e-3, 1.0, 0.0) <= 0.1 * FOOT_SHIFT_OF_ANY


def test_shorter_elements_at_the_rims_of_feet_lower_modes_as_stated(tmp_path):
    # 5·10⁻⁴ in the second mode
    shifts, found = [], []
    for corner in ({}, {"corner_size_m": 1.5e-3}):
        mesh = {**triangles(0.14), **corner}
        panel, _ = of([0.7, 0.5], THIN, mesh, 500, held(foot(0.3, 0.35, 0.03)), patches={})
        studied = StudiedPanel(Panel(**panel))
        basis = basis_for(studied, 120.0, tmp_path)
        few = np.flatnonzero(~basis.is_residual & (basis.natural_frequency > 1))[:5]
        frequency, none = basis.natural_frequency[few], np.zeros((0, len(few)))
        shape = (np.eye(len(basis.modal_mass)) / np.sqrt(basis.modal_mass))[:, few]
        modes = LoadedModes(frequency, np.ones(len(few)), none, shape)
        shifts.append(MARGIN * mode_shifts(basis, modes, np.zeros(0), studied.wave_shift)[0])
        found.append(frequency)
    true = found[0] / found[1] - 1
    of_feet = true > 2e-5
    ratio = ((shifts[0] - shifts[1]) / true)[of_feet]
    assert of_feet.sum() >= 3 and np.all((ratio > 1) & (ratio < 2)), ratio
    assert studied.cause_of_shift(1e-3, 10.0) == "feet"
