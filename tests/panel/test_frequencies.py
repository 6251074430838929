"""Truths of natural frequencies: closed forms, published targets, embedded modes, convergence."""

import numpy as np
import pytest
from scipy.optimize import brentq

from pidpanel.geometry.polygon import Circle, Polygon, Rectangle
from pidpanel.panel import mindlin
from pidpanel.panel.attachments import Attachment, with_attachments
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.mindlin import assemble_shear_plate
from pidpanel.panel.modes import count_modes_below, normal_modes
from pidpanel.panel.navier import shear_plate_frequency, thin_plate_frequency
from pidpanel.panel.section import Core, Material, Ply, SandwichSection, SolidSection, ThinSection
from pidpanel.panel.shapes import residual_vectors
from pidpanel.panel.supports import EdgeSupport, PointSupport, Supports
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.panel.triangles import mesh_triangles
from tests.panel_basis import panel_basis

SIZE = (1.5, 1.0)
OUTLINE = Polygon(((0.0, 0.0), (1.5, 0.0), (1.5, 1.0), (0.0, 1.0)))
THIN = ThinSection(3273.07, 4.0)
FACE = Ply(Material.isotropic(60e9, 0.3, 1600.0), 0.3e-3)
SANDWICH = SandwichSection((FACE,), (FACE,), Core(186e6, 90e6, 32.0, 24.4e-3))
# an L of three unit cells, 0.5 m each
L_SHAPE = Polygon(((0, 0), (1, 0), (1, 0.5), (0.5, 0.5), (0.5, 1), (0, 1)))
CELL = (0.5, 0.5)


def split_quads(nx, ny, size=SIZE):
    """A regular mesh of triangles, independent of gmsh, so that refinements are nested."""
    x, y = np.meshgrid(np.linspace(0, size[0], nx + 1), np.linspace(0, size[1], ny + 1))
    corner = (np.arange(ny)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    right, up = corner + 1, corner + nx + 1
    cells = np.vstack(
        [np.column_stack([corner, right, up + 1]), np.column_stack([corner, up + 1, up])]
    )
    return PanelMesh(np.column_stack([x.ravel(), y.ravel()]), cells, "triangles", {}, {})


def test_the_closed_form_of_the_sandwich_gives_the_reference_numbers():
    # a separate solution of the Navier series to six digits
    m, n = np.array([(1, 1), (2, 1), (1, 2), (3, 1), (2, 2), (3, 2), (3, 3)]).T
    expected = [131.395, 250.475, 389.143, 444.475, 501.871, 685.934, 1055.296]
    np.testing.assert_allclose(shear_plate_frequency(m, n, SIZE, SANDWICH), expected, rtol=4e-6)


def test_shear_elements_converge_to_navier_from_above_at_order_4():
    m, n = np.array([(1, 1), (2, 1), (1, 2), (3, 1)]).T
    exact = np.sort(shear_plate_frequency(m, n, SIZE, SANDWICH))
    errors = []
    for count in (3, 6, 12):
        plate = assemble_shear_plate(split_quads(3 * count // 2, count), SANDWICH)
        frequency, _ = normal_modes(plate, 480.0)
        errors.append(frequency[:4] / exact - 1)
    errors = np.array(errors)
    assert errors.min() > 0  # conforming and exactly integrated
    orders = np.log2(errors[:-1] / errors[1:])
    # P2 rotations: energy errs as h^4, a little faster while the mesh is coarse
    assert 3.9 < orders.min() and orders.max() < 4.7
    assert orders[-1].max() < 4.25
    assert errors[-1].max() < 1e-4


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["thin", "shear"])
def test_an_l_shape_has_the_sines_of_its_cells_among_its_modes(tmp_path, kind):
    mesh = mesh_triangles(tmp_path / "l.msh", L_SHAPE, 0.15, {}, {}, corner_size=2e-3)
    orders = np.array([(1, 1), (1, 2), (2, 2)]).T
    if kind == "thin":
        plate = assemble_thin_plate(mesh, THIN)
        exact = thin_plate_frequency(*orders, CELL, ThinSection(3273.07, 4.0))
        tolerance = 2e-5
    else:
        # sines that vanish on the lines of the cells are modes of an isotropic section only
        core = Core(90e6, 90e6, 32.0, 24.4e-3)
        section = SandwichSection((FACE,), (FACE,), core)
        plate = assemble_shear_plate(mesh, section)
        exact = shear_plate_frequency(*orders, CELL, section)
        tolerance = 3e-3  # 2.5 to 4 elements to a half wave; 5e-4 at the first, below
    frequency, _ = normal_modes(plate, 1.05 * exact.max())
    nearest = np.abs(frequency[:, None] / exact - 1).min(axis=0)
    assert nearest.max() < tolerance
    assert nearest[0] < 5e-4
    # and other modes than these, below the first of them
    assert np.sum(frequency < 0.99 * exact[0]) == 2


@pytest.mark.slow
def test_refinement_into_a_reentrant_corner_lowers_the_frequency_as_its_size_to_the_2_3(tmp_path):
    found = []
    for corner_size in (0.064, 0.016, 0.004, 0.001):
        mesh = mesh_triangles(tmp_path / "l.msh", L_SHAPE, 0.25, {}, {}, corner_size=corner_size)
        found.append(normal_modes(assemble_thin_plate(mesh, THIN), 260.0)[0][0])
    steps = -np.diff(found)
    assert (steps > 0).all()  # conforming: from above
    orders = np.log(steps[1:] / steps[:-1]) / np.log(1 / 4)
    # w ~ r^(4/3) at a simply supported corner of 270 degrees; its energy errs as h^(2/3)
    assert 0.5 < orders.min() and orders.max() < 0.85
    # what is left after the last step is 1 / (4^(2/3) - 1) = 0.66 of it
    assert 0.66 * steps[-1] / found[-1] < 6e-3


def test_a_soft_simple_support_is_a_little_weaker_than_a_hard_one(tmp_path):
    mesh = split_quads(12, 8)
    soft, hard = (
        normal_modes(assemble_shear_plate(mesh, SANDWICH, Supports(kind)), 260.0)[0]
        for kind in ("simply_supported_soft", "simply_supported")
    )
    # the layer at a soft edge twists: 1 % of the first, known from finer meshes
    assert ((hard / soft - 1) > 2e-3).all()
    assert ((hard / soft - 1) < 0.025).all()


@pytest.mark.parametrize("section", [THIN, SANDWICH], ids=["thin", "sandwich"])
def test_a_free_panel_moves_as_a_rigid_body_in_three_ways(section):
    assemble = assemble_thin_plate if section is THIN else assemble_shear_plate
    mesh = split_quads(6, 4)
    plate = assemble(mesh, section, Supports("free"))
    frequency, modes = normal_modes(plate, 250.0)
    assert np.sum(frequency == 0) == 3
    assert frequency[3] > 10
    # each rigid mode is a plane
    plane = np.column_stack([np.ones(len(mesh.vertices)), mesh.vertices])
    w = plate.at_vertices @ modes[:, :3]
    rest = w - plane @ np.linalg.lstsq(plane, w, rcond=None)[0]
    assert np.abs(rest).max() < 1e-6
    assert count_modes_below(plate, 5.0) == 3


def test_two_hinges_leave_one_rigid_motion_and_a_third_off_their_line_none(tmp_path):
    mesh = split_quads(6, 4)
    hinges = {"A": PointSupport((0.5, 0.0), "hinge"), "B": PointSupport((1.0, 0.0), "hinge")}
    third = {"C": PointSupport((0.75, 1.0), "hinge")}
    for points, rigid in ((hinges, 1), (hinges | third, 0), ({"A": hinges["A"]}, 2)):
        plate = assemble_thin_plate(mesh, THIN, Supports("free", points=points))
        frequency, _ = normal_modes(plate, 150.0)
        assert np.sum(frequency == 0) == rigid


def test_a_free_panel_with_a_patch_has_residual_vectors_and_a_finite_answer(tmp_path):
    patch = {"P": Rectangle((0.5, 0.5), (0.4, 0.4))}
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", SIZE, (15, 10), patch, {})
    plate = assemble_thin_plate(mesh, THIN, Supports("free"))
    basis = panel_basis(mesh, plate, 300.0)
    assert np.sum(basis.natural_frequency == 0) == 3
    assert basis.is_residual.any()
    frequency, residuals = residual_vectors(plate, normal_modes(plate, 300.0)[1], 1e-4)
    assert np.isfinite(residuals).all() and frequency.min() > 100
    # under a unit pressure at 20 Hz the panel accelerates as its mass tells, away from resonance
    stiffness = (2 * np.pi * basis.natural_frequency) ** 2 * basis.modal_mass
    omega = 2 * np.pi * 0.5
    load = basis.shape_at_quadrature.T @ basis.quadrature_weight
    w = basis.shape_at_vertices @ (load / (stiffness - omega**2 * basis.modal_mass))
    # bending at a hundredth of the first frequency adds (0.5/45)^2
    np.testing.assert_allclose(-(omega**2) * w, 1 / 4.0, rtol=1e-3)


@pytest.mark.parametrize("section", [THIN, SANDWICH], ids=["thin", "sandwich"])
def test_a_clamped_edge_of_a_strip_is_that_of_a_beam(section):
    # a cantilever strip with nu = 0 is a beam: k L = 1.8751 (Euler-Bernoulli)
    size = (1.0, 0.1)
    mesh = split_quads(12, 1, size)
    if section is THIN:
        section = ThinSection(1000.0, 4.0, poissons_ratio=0.0)
        assemble = assemble_thin_plate
    else:
        # thin enough for shear and rotary inertia to take 1e-4
        section = SolidSection(70e9, 0.0, 2700.0, 0.004)
        assemble = assemble_shear_plate
    held = Supports("free", edges=[EdgeSupport((0, 0), (0, 0.1), "clamped")])
    frequency, _ = normal_modes(assemble(mesh, section, held), 60.0)
    beam = 1.8751041**2 * np.sqrt(section.bending[0, 0] / section.mass_per_area) / (2 * np.pi)
    # 2e-3: shear elements in the thin limit
    assert frequency[0] == pytest.approx(beam, rel=2e-3)


def receptance(frequency, position, count=400):
    """w / F at a point of the thin rectangle: sum of phi^2 / (m (w_mn^2 - w^2)), Navier."""
    m, n = np.mgrid[1 : count + 1, 1 : count + 1]
    own = 2 * np.pi * thin_plate_frequency(m, n, SIZE, ThinSection(3273.07, 4.0))
    phi = np.sin(m * np.pi * position[0] / SIZE[0]) * np.sin(n * np.pi * position[1] / SIZE[1])
    return np.sum(phi**2 / (1.5 * (own**2 - (2 * np.pi * frequency) ** 2)))


@pytest.mark.parametrize(
    ("attached", "impedance", "bracket"),
    [
        # 1 / receptance + what is attached = 0, between the poles of the receptance
        (Attachment([(0.4, 0.3)], 2.0), lambda f: -2.0 * (2 * np.pi * f) ** 2, (1.0, 64.8)),
        (Attachment([(0.4, 0.3)], stiffness=5e5), lambda f: 5e5, (65.0, 124.0)),
    ],
    ids=["mass", "spring"],
)
def test_a_mass_or_a_spring_moves_the_first_frequency_as_the_receptance_says(
    tmp_path, attached, impedance, bracket
):
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", SIZE, (15, 10), {}, {})
    plate = with_attachments(assemble_thin_plate(mesh, THIN), [attached], mesh)
    exact = brentq(
        lambda f: 1 + receptance(f, attached.ends[0]) * impedance(f), *bracket, xtol=1e-6
    )
    frequency, _ = normal_modes(plate, 300.0)
    # elements of 10 cm under a point force; the series is cut at 400 x 400: 1e-5
    assert frequency[0] == pytest.approx(exact, rel=1e-3)
    assert abs(exact / 64.9 - 1) > 0.05


@pytest.mark.slow
def test_a_mass_along_a_line_is_many_point_masses(tmp_path):
    mesh = mesh_quadrilaterals(tmp_path / "m.msh", SIZE, (6, 4), {}, {})
    plate = assemble_thin_plate(mesh, THIN)
    line = Attachment([(0.1, 0.2), (1.3, 0.7)], 3.0)
    share = (np.arange(80) + 0.5) / 80
    points = [Attachment([(0.1 + 1.2 * s, 0.2 + 0.5 * s)], 3.0 / 80) for s in share]
    one, many = (with_attachments(plate, what, mesh).mass for what in ([line], points))
    # the midpoint rule with 80 points errs by (h k)^2 / 24
    scale = abs(plate.mass).max()
    assert abs(one - many).max() < 2e-3 * abs(one - plate.mass).max()
    assert abs(one - plate.mass).max() > 0.01 * scale


@pytest.mark.slow
def test_a_stiff_foot_holds_as_a_clamped_hole_of_its_size(tmp_path):
    # nothing moves within a hold-down: the panel is that with a clamped hole
    foot = Circle((0.6, 0.5), 0.1, 24)
    held = Supports("free", points={"H": PointSupport((0.6, 0.5), "hold_down", 0.1)})
    hole = Supports("free", holes="clamped")
    for assemble, section in ((assemble_thin_plate, THIN), (assemble_shear_plate, SANDWICH)):
        with_foot = mesh_triangles(tmp_path / "f.msh", OUTLINE, 0.3, {}, {}, imprints={"H": foot})
        with_hole = mesh_triangles(tmp_path / "h.msh", OUTLINE, 0.3, {}, {}, holes={"H": foot})
        one = normal_modes(assemble(with_foot, section, held), 120.0)[0]
        other = normal_modes(assemble(with_hole, section, hole), 120.0)[0]
        # thin: second derivatives are continuous at vertices, so the rim of the foot has none
        excess = one[:3] / other[:3] - 1
        assert np.abs(excess).max() < (7e-3 if section is THIN else 1e-3), excess


def test_a_hinged_foot_turns_and_does_not_heave(tmp_path):
    foot = Circle((0.75, 0.5), 0.1, 24)
    mesh = mesh_triangles(tmp_path / "f.msh", OUTLINE, 0.3, {}, {}, imprints={"H": foot})
    held = Supports("free", points={"H": PointSupport((0.75, 0.5), "hinge", 0.1)})
    frequency, _ = normal_modes(assemble_shear_plate(mesh, SANDWICH, held), 120.0)
    assert np.sum(frequency == 0) == 2


@pytest.mark.slow
def test_a_hinged_foot_of_a_thin_plate_turns_about_its_middle(tmp_path):
    foot = Circle((0.6, 0.4), 0.1, 24)
    mesh = mesh_triangles(tmp_path / "f.msh", OUTLINE, 0.4, {}, {}, imprints={"H": foot})
    held = Supports("free", points={"H": PointSupport((0.6, 0.4), "hinge", 0.1)})
    plate = assemble_thin_plate(mesh, THIN, held)
    frequency, modes = normal_modes(plate, 120.0)
    assert np.sum(frequency == 0) == 2
    np.testing.assert_allclose(
        plate.interpolate(np.array([[0.6, 0.4]])) @ modes[:, :2], 0, atol=1e-9
    )


def test_points_hold_a_plate_with_shear_as_they_hold_a_thin_one():
    # a point that is held leaves two rotations, two leave one, a hold-down none
    mesh = split_quads(6, 4)
    hinge, other = PointSupport((0.5, 0.5), "hinge"), PointSupport((1.0, 0.75), "hinge")
    for points, rigid in (
        ({"A": hinge}, 2),
        ({"A": hinge, "B": other}, 1),
        ({"A": PointSupport((0.5, 0.5), "hold_down")}, 0),
    ):
        plate = assemble_shear_plate(mesh, SANDWICH, Supports("free", points=points))
        assert np.sum(normal_modes(plate, 150.0)[0] == 0) == rigid


def test_a_point_held_down_and_a_hinged_foot_each_hold_their_own():
    points = {"A": PointSupport((0.25, 0.25), "hold_down"),
              "F": PointSupport((1.0, 0.5), "hinge", 0.3)}  # fmt: skip
    plate = assemble_shear_plate(split_quads(6, 4), SANDWICH, Supports("free", points=points))
    held = np.array([(0.25, 0.25), (1.0, 0.5)])
    np.testing.assert_allclose(plate.interpolate(held).toarray(), 0, atol=1e-12)


def test_one_clamped_edge_holds_the_same_whichever_of_two_opposite_ones_it_is():
    # the mesh is its own image under half a turn
    mesh = split_quads(6, 4)
    found = [
        normal_modes(
            assemble_shear_plate(mesh, SANDWICH, Supports(edges=[EdgeSupport(*ends, "clamped")])),
            600.0,
        )[0]
        for ends in (((0, 0), (0, 1)), ((1.5, 0), (1.5, 1)), ((0, 0), (1.5, 0)), ((0, 1), (1.5, 1)))
    ]
    np.testing.assert_allclose(found[0], found[1], rtol=1e-9)
    np.testing.assert_allclose(found[2], found[3], rtol=1e-9)
    simple = normal_modes(assemble_shear_plate(mesh, SANDWICH), 600.0)[0]
    clamped = normal_modes(assemble_shear_plate(mesh, SANDWICH, Supports("clamped")), 600.0)[0]
    for one in found:
        assert simple[0] < one[0] < clamped[0]


def test_supports_that_hold_one_place_twice_are_named():
    mesh = split_quads(6, 4)
    points = {
        "H": PointSupport((0.5, 0.5), "hold_down", 0.3),
        "I": PointSupport((0.5, 0.5), "hinge"),
    }
    with pytest.raises(ValueError, match="H and I hold the same coordinate"):
        assemble_thin_plate(mesh, THIN, Supports("free", points=points))


@pytest.mark.parametrize(
    ("supports", "message"),
    [
        (
            Supports(edges=[EdgeSupport((0, 0), (0.7, 0), "free")]),
            r"support from \(0, 0\) to \(0.7, 0\) m: edges of the panel's boundary cover 0.5 of its 0.7 m",
        ),
        (
            Supports(points={"H": PointSupport((0.3, 0.3), "hinge")}),
            r"H at \(0.3, 0.3\) m: no vertex of the mesh is there, the nearest is \(0.25, 0.25\) m",
        ),
    ],
)
def test_supports_that_do_not_fit_the_mesh_are_refused(supports, message):
    with pytest.raises(ValueError, match=message):
        assemble_thin_plate(split_quads(6, 4), THIN, supports)


@pytest.mark.parametrize(("count", "tolerance", "of_shear"), [(4, 0.12, 0.35), (8, 0.03, 0.06)])
def test_curvature_and_shear_of_the_sandwich_are_those_of_its_closed_form(
    count, tolerance, of_shear
):
    mesh = split_quads(3 * count // 2, count)
    plate = assemble_shear_plate(mesh, SANDWICH)
    frequency, modes = normal_modes(plate, 200.0)
    p, q = np.pi / SIZE[0], np.pi / SIZE[1]
    # static relations of w = sin(px) sin(qy) with rotations X cos sin, Y sin cos: rows 2 and 3 of
    # the Navier system at the frequency
    D, S, I = SANDWICH.bending, SANDWICH.shear, SANDWICH.rotary_inertia
    inertia = I * (2 * np.pi * frequency[0]) ** 2
    system = np.array(
        [
            [D[0, 0] * p**2 + D[2, 2] * q**2 + S[0, 0] - inertia, (D[0, 1] + D[2, 2]) * p * q],
            [(D[0, 1] + D[2, 2]) * p * q, D[2, 2] * p**2 + D[1, 1] * q**2 + S[1, 1] - inertia],
        ]
    )
    X, Y = np.linalg.solve(system, [S[0, 0] * p, S[1, 1] * q])
    x, y = mesh.vertices.T
    sx, cx, sy, cy = np.sin(p * x), np.cos(p * x), np.sin(q * y), np.cos(q * y)
    curvature = [p * X * sx * sy, q * Y * sx * sy, -(q * X + p * Y) * cx * cy]
    shear = [(p - X) * cx * sy, (q - Y) * sx * cy]
    u = modes[:, 0]
    for found, expected in zip(plate.curvature_at_vertices, curvature, strict=True):
        # means of gradients of quadratics err as h^2
        np.testing.assert_allclose(found @ u, expected, atol=tolerance * np.abs(expected).max())
    for found, expected in zip(plate.shear_at_vertices, shear, strict=True):
        # the shear angle is a tenth of the slopes whose difference it is
        np.testing.assert_allclose(found @ u, expected, atol=of_shear * np.abs(expected).max())


def test_rigid_motions_have_the_mass_and_the_moments_of_inertia_of_a_slab():
    mesh = split_quads(6, 4)
    plate = assemble_shear_plate(mesh, SANDWICH, Supports("free"))
    _, modes = normal_modes(plate, 300.0)
    plane = np.column_stack([np.ones(len(mesh.vertices)), mesh.vertices])
    slopes = np.linalg.lstsq(plane, plate.at_vertices @ modes[:, :3], rcond=None)[0]
    motion = modes[:, :3] @ np.linalg.inv(slopes)  # w = 1, w = x, w = y
    a, b = SIZE
    moments = (
        a
        * b
        * np.array([[1, a / 2, b / 2], [a / 2, a**2 / 3, a * b / 4], [b / 2, a * b / 4, b**2 / 3]])
    )
    expected = SANDWICH.mass_per_area * moments
    expected += SANDWICH.rotary_inertia * a * b * np.diag([0, 1, 1])
    # 1e-6 tells the rotary inertia, 3e-4 of the moments; Lanczos finds rigid modes to 1e-8
    np.testing.assert_allclose(motion.T @ (plate.mass @ motion), expected, rtol=1e-6)


SKEW = Polygon(((0, 0), (1, 0), (1.5, 0.8), (0.5, 0.8)))


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["clamped", "free"])
def test_a_thin_solid_does_not_lock(tmp_path, kind):
    # beside quintics of a thin plate; at 0.5 mm shear takes (k t)²/7 = 1e-5 of a frequency
    solid = SolidSection(70e9, 0.33, 2700.0, 0.5e-3)
    thin = ThinSection(float(solid.bending[0, 0]), solid.mass_per_area, 0.33, 0.5e-3)
    mesh = mesh_triangles(tmp_path / "s.msh", SKEW, 0.08, {}, {})
    exact, found = (
        normal_modes(assemble(mesh, section, Supports(kind)), 10.0, 15)[0][:15]
        for assemble, section in ((assemble_thin_plate, thin), (assemble_shear_plate, solid))
    )
    elastic = exact > 0
    assert elastic.sum() >= 12 and np.array_equal(found > 0, elastic)
    # quartics at two elements to the shortest half wave
    np.testing.assert_allclose(found[elastic], exact[elastic], rtol=1e-3)


@pytest.mark.parametrize(
    "supports",
    [
        Supports(),
        Supports("simply_supported_soft"),
        Supports("clamped"),
        Supports("free", points={"H": PointSupport((0.5, 0.5), "hold_down", 0.3)}),
        Supports("free", points={"H": PointSupport((0.5, 0.5), "hinge", 0.3)}),
    ],
)
def test_quartics_hold_more_shapes_than_cubics_under_every_support(monkeypatch, supports):
    # both conform, so that frequencies of the same mesh fall; at 25 cm they differ by 0.1 to 8 %
    mesh = split_quads(6, 4)
    cubic = normal_modes(assemble_shear_plate(mesh, SANDWICH, supports), 600.0)[0]
    monkeypatch.setattr(mindlin, "SANDWICH_DEGREE", 4)
    quartic = normal_modes(assemble_shear_plate(mesh, SANDWICH, supports), 600.0)[0]
    count = np.sum(cubic == 0)
    assert np.sum(quartic == 0) == count
    fall = 1 - quartic[count : len(cubic)] / cubic[count:]
    assert fall.min() > -1e-9
    assert fall.max() < 0.08
