"""Files of CalculiX 2.20: the paraboloid of the shipped study, and shells by the format."""

import re

import numpy as np
import pytest

from pidpanel.geometry.orientation import oriented
from pidpanel.modal_files import read_modes
from pidpanel.modal_files.calculix import read_mesh
from pidpanel.modal_files.model import modal_model
from pidpanel.modal_files.quadrature import surface_quadrature
from pidpanel.modal_files.residual import residual_vectors
from pidpanel.modal_files.shapes import ModeShapes
from pidpanel.paths import PROJECT

FILES = PROJECT / "workflow" / "data" / "modes"
AREAL_MASS = 2 * 0.3e-3 * 1600 + 12e-3 * 50  # of the inputs of make.py [kg/m²]
PARTS = [f"{patch}_{k}" for patch in ("INNER", "OUTER") for k in range(1, 7)]


@pytest.fixture(scope="module")
def paraboloid():
    return read_modes(FILES / "paraboloid.frd", FILES / "paraboloid.inp", 1.0)


def test_the_surface_is_the_paraboloid(paraboloid):
    radius = np.hypot(*paraboloid.position[:, :2].T)
    np.testing.assert_allclose(paraboloid.position[:, 2], radius**2 / (4 * 0.48), atol=1e-6)
    area = 2 * np.pi / 3 * 0.96**2 * np.diff((1 + (np.array([0.12, 0.6]) / 0.96) ** 2) ** 1.5)
    weight = surface_quadrature(paraboloid.position, paraboloid.cells).weight
    # cells between 44 radii are chords
    assert weight.sum() == pytest.approx(area[0], rel=1.1 * (2 * np.pi / 44) ** 2 / 6)


def test_its_modes_are_those_of_own_shells_and_move_its_mass(paraboloid):
    shells = [75.60, 102.63, 153.21, 266.00, 286.19]  # of another formulation [Hz]
    np.testing.assert_allclose(paraboloid.frequency[[0, 2, 4, 6, 8]], shells, rtol=3e-3)
    # in plane rotations of the layers, which the middle does not show, have up to 6 %
    np.testing.assert_allclose(paraboloid.areal_mass[:9], AREAL_MASS, rtol=0.02)
    assert len(paraboloid.frequency) == 20
    assert paraboloid.static_displacement.shape[2] == 12


@pytest.fixture(scope="module")
def patches(paraboloid):
    cells = oriented(paraboloid.position, paraboloid.cells, [0, 0, 1.0])
    quadrature = surface_quadrature(paraboloid.position, cells)
    pressure = [np.isin(quadrature.cell, paraboloid.groups[name]) for name in PARTS]
    return quadrature, np.stack(pressure, axis=1).astype(float)


def test_static_cases_do_equal_work_on_each_other(paraboloid, patches):
    """Maxwell and Betti: patches, sides and the order of nodes are those of CalculiX."""
    quadrature, pressure = patches
    load = quadrature.weight[:, None] * pressure
    work = quadrature.normal_displacement(paraboloid.static_displacement).T @ load
    np.testing.assert_allclose(work, work.T, atol=2e-3 * np.abs(work).max())
    assert (np.diag(work) > 0).all()


def test_residual_vectors_complete_the_compliance_of_patches(paraboloid, patches):
    quadrature, pressure = patches
    model = paraboloid
    vectors = residual_vectors(quadrature, model.frequency, model.modal_mass, model.displacement,
                               model.static_displacement, pressure, AREAL_MASS)  # fmt: skip
    load = quadrature.weight[:, None] * pressure
    compliance = np.zeros((12, 12))
    for frequency, mass, motion in (
        (model.frequency, model.modal_mass, model.displacement),
        (vectors.frequency, vectors.modal_mass, vectors.displacement),
    ):
        force = quadrature.normal_displacement(motion).T @ load
        compliance += force.T @ (force / ((2 * np.pi * frequency) ** 2 * mass)[:, None])
    work = quadrature.normal_displacement(model.static_displacement).T @ load
    np.testing.assert_allclose(compliance, work, atol=2e-3 * work.max())
    assert vectors.frequency.min() > model.frequency.max()
    against = residual_vectors(quadrature, model.frequency, model.modal_mass, model.displacement,
                               model.static_displacement, -pressure, AREAL_MASS)  # fmt: skip
    np.testing.assert_allclose(against.frequency, vectors.frequency)


def test_displacements_of_other_pressures_are_refused(paraboloid, patches):
    quadrature, pressure = patches
    model = paraboloid
    modes = model.frequency, model.modal_mass, model.displacement
    for static, message in (
        (model.static_displacement[:, :, ::-1], "do work on each other that differs by"),
        (0.5 * model.static_displacement, r"static case \d+: modes alone move \d+% of it"),
    ):
        with pytest.raises(ValueError, match=message):
            residual_vectors(quadrature, *modes, static, pressure, AREAL_MASS)
    with pytest.raises(ValueError, match="need a structure without rigid motions"):
        residual_vectors(quadrature, 0 * modes[0], *modes[1:], static, pressure, AREAL_MASS)


def frd(
    plate, *, mass="    1PGM                {:.6E}\n", width=10, mode=True, component="DISP", form=1
):
    """Nodes and results of a plate in the columns of the format."""

    def lines(vectors):
        return "".join(
            f" -1{node:{width}}" + "".join(f"{value:12.5E}" for value in vector) + "\n"
            for node, vector in zip(plate.node, vectors, strict=True)
        )  # fmt: skip

    text = f"    1C\n    2C{len(plate.node):30}{form:38}\n{lines(plate.position)} -3\n"
    for k, frequency in enumerate(plate.frequency, 1):
        text += f"    1PSTEP{k:26}{1:12}{1:12}\n" + mass.format(plate.modal_mass[k - 1])
        text += f"    1PMODE{k:26}\n" if mode else ""
        text += (
            f"  100CL  {100 + k:3}{frequency:12.8g}{len(plate.node):12}{'':20}{2 if mode else 0:2}"
        )
        text += f"{k:5}{'MODAL' if mode else '':10}{form:2}\n -4  {component:8}{4:5}{1:5}\n"
        text += "".join(f" -5  D{c}{1:11}{2:5}{c:5}{0:5}\n" for c in (1, 2, 3))
        text += lines(plate.displacement[:, :, k - 1]) + " -3\n"
    return text + " 9999\n"


def inp(plate):
    nodes = "".join(
        f"{n}, {x:.9g}, {y:.9g}, {z:.9g}\n"
        for n, (x, y, z) in zip(plate.node, plate.position, strict=True)
    )
    elements = "".join(f"{100 + k}, " + ",".join(map(str, corners)) + "\n"
                       for k, corners in enumerate(plate.corners))  # fmt: skip
    return (f"** a plate\n*Node, nset=all\n{nodes}*Element, type=S4R, elset=skin\n{elements}"
            "*Elset, elset=row, generate\n100, 111\n*Elset, elset=both\nrow, 120, 121,\n"
            "*Surface, name=top\nrow, spos\n*Step\n")  # fmt: skip


def read(tmp_path, results, mesh, **options):
    (tmp_path / "plate.frd").write_text(results)
    (tmp_path / "plate.inp").write_text(mesh)
    return read_modes(tmp_path / "plate.frd", tmp_path / "plate.inp", 1.0, **options)


@pytest.mark.parametrize(("width", "form"), [(10, 1), (5, 0)])
def test_shells_have_the_modes_of_their_nodes(plate, tmp_path, width, form):
    model = read(tmp_path, frd(plate, width=width, form=form), inp(plate))
    np.testing.assert_allclose(model.displacement, plate.displacement, atol=1e-5)
    np.testing.assert_allclose(model.frequency, plate.frequency, rtol=1e-6)
    np.testing.assert_allclose(model.areal_mass, 3.0, rtol=1e-4)
    counts = {name: len(cells) for name, cells in model.groups.items()}
    assert counts == {"SKIN": 96, "ROW": 12, "BOTH": 14, "TOP": 12}


def test_results_without_mass_or_mode_are_refused_or_static(plate, tmp_path):
    with pytest.raises(ValueError, match="mode 1 has no modal mass"):
        read(tmp_path, frd(plate, mass=""), inp(plate))
    with pytest.raises(ValueError, match="no real normal modes of displacements"):
        read(tmp_path, frd(plate, mode=False), inp(plate))
    with pytest.raises(ValueError, match="has complex modes; real normal modes are needed"):
        read(tmp_path, frd(plate, component="DISPI"), inp(plate))
    response = frd(plate, component="DISPI", mode=False).split("    1PSTEP", 1)[1]
    beside = frd(plate).replace(" 9999\n", "    1PSTEP" + response)
    assert len(read(tmp_path, beside, inp(plate)).frequency) == 4
    with pytest.raises(ValueError, match="is binary; CalculiX writes text"):
        read(tmp_path, frd(plate, form=2), inp(plate))
    with pytest.raises(ValueError, match=r"lines after .* have not the columns"):
        read(tmp_path, frd(plate).replace("\n -1 ", "\n -1  ", 1), inp(plate))


def test_a_mesh_of_another_model_is_refused(plate, tmp_path):
    moved = plate._replace(position=plate.position + [0.01, 0, 0] * (plate.node == 8)[:, None])
    with pytest.raises(
        ValueError, match=r"node 8: mesh and modes differ by 0.01 m in its position"
    ):
        read(tmp_path, frd(plate), inp(moved))
    with pytest.raises(
        ValueError, match=r"plate.inp: \*SURFACE: an element of 8 nodes has faces S1"
    ):
        solid = "*Node\n1,0,0,0\n*Element, type=C3D8, elset=a\n1,1,2,3,4,5,6,7,8\n*Surface, name=s\na,S7\n"
        read(tmp_path, frd(plate), solid)
    expanded = frd(plate._replace(node=plate.node + 1000))  # shells become solids with other nodes
    with pytest.raises(ValueError, match=r"is not in the modes; 96 elements .* needs OUTPUT=2D"):
        read(tmp_path, expanded, inp(plate))
    with pytest.raises(ValueError, match="no surface elements; triangles or quadrilaterals"):
        read(tmp_path, frd(plate), inp(plate).replace("S4R", "B32X"))


def elements(kind, corners):
    """Elements of a result by the format, of two materials."""
    text = f"    3C{len(corners):30}{1:38}\n"
    for k, nodes in enumerate(corners, 1):
        text += f" -1{k:10}{kind:5}{0:5}{1 + k % 2:5}\n -2"
        text += "".join(f"{node:10}" for node in nodes) + "\n"
    return text + " -3\n"


def with_elements(results, text):
    return results.replace(" -3\n", " -3\n" + text, 1)


def test_a_result_with_shells_is_its_own_mesh(plate, tmp_path):
    path = tmp_path / "plate.frd"
    path.write_text(with_elements(frd(plate), elements(9, plate.corners)))
    model = read_modes(path, unit_m=1.0)
    np.testing.assert_allclose(model.displacement, plate.displacement, atol=1e-5)
    np.testing.assert_allclose(model.areal_mass, 3.0, rtol=1e-4)
    assert {name: len(cells) for name, cells in model.groups.items()} == {"1": 48, "2": 48}


def test_elements_without_all_their_nodes_and_twice_are_refused(plate, tmp_path):
    path, text = tmp_path / "plate.frd", elements(9, plate.corners)
    for broken in (text.replace("\n -2 ", "\n -2 x", 1), text.replace("\n -2", "\n -2        77")):
        path.write_text(with_elements(frd(plate), broken))
        with pytest.raises(ValueError, match="nodes of element '1    9    0    2' cannot be read"):
            read_modes(path, unit_m=1.0)
    solids = np.hstack([plate.corners, 10000 + plate.corners])
    path.write_text(with_elements(frd(plate), elements(1, solids)))
    with pytest.raises(ValueError, match=r"node 10\d+ of an element is not there"):
        read_modes(path, unit_m=1.0)
    with pytest.raises(ValueError, match=r"ELEMENT cannot be read .*element 100 appears twice"):
        read(tmp_path, frd(plate), inp(plate) + "*Element, type=S4\n100,5,8,11,14\n")


def expanded(plate, layers=1):
    """Solids of a plate, 0.1 m thick, with a stretch in thickness besides its modes."""
    levels = np.arange(layers + 1)
    shift = plate.normal * 0.1 * (levels[:, None, None] - layers / 2)
    stretch = plate.normal[:, None] * (levels[:, None, None, None] - layers / 2)
    nodes = np.concatenate([plate.node + 1000 * k for k in levels])
    solid = plate._replace(
        node=nodes,
        position=(plate.position + shift).reshape(-1, 3),
        displacement=(plate.displacement + stretch).reshape(len(nodes), 3, -1),
    )
    corners = [np.hstack([plate.corners + 1000 * k, plate.corners + 1000 * (k + 1)])
               for k in range(layers)]  # fmt: skip
    return with_elements(frd(solid), elements(1, np.concatenate(corners)))


def test_solids_of_shells_have_the_motion_of_their_middle(plate, tmp_path):
    path = tmp_path / "plate.frd"
    path.write_text(expanded(plate))
    model = read_modes(path, unit_m=1.0)
    np.testing.assert_allclose(model.areal_mass, 3.0, rtol=1e-4)
    where = np.linalg.norm(model.position[:, None] - plate.position, axis=2).argmin(axis=1)
    np.testing.assert_allclose(model.position, plate.position[where], atol=1e-5)
    np.testing.assert_allclose(model.displacement, plate.displacement[where], atol=2e-5)
    blank = f" -1{plate.node[0]:10}"
    text = expanded(plate)
    path.write_text(
        text[: text.index(" 100CL")]
        + re.sub(rf"(?m)^{blank}.*\n", "", text[text.index(" 100CL") :])
    )
    with pytest.raises(ValueError, match=f"node {plate.node[0]} has no displacement"):
        read_modes(path, unit_m=1.0)
    path.write_text(text.replace("1PMODE", "1PSOME"))
    with pytest.raises(ValueError, match="no real normal modes of displacements"):
        read_modes(path, unit_m=1.0)
    path.write_text(expanded(plate, layers=2))
    with pytest.raises(ValueError, match="solids lie one on another"):
        read_modes(path, unit_m=1.0)


def test_each_face_of_a_solid_looks_out_of_it(tmp_path):
    """The faces of a cube, a wedge and a tetrahedron enclose their volumes, with middles too."""
    cube = np.array(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]]
    )
    corners = {"C3D20R": (cube, 6, 1.0), "C3D15": (cube[[0, 1, 3, 4, 5, 7]], 5, 0.5),
               "C3D10": (cube[[0, 1, 3, 4]], 4, 1 / 6), "C3D8": (cube, 6, 1.0)}  # fmt: skip
    edges = {"C3D20R": "12 23 34 41 56 67 78 85 15 26 37 48", "C3D15": "12 23 31 45 56 64 14 25 36",
             "C3D10": "12 23 31 14 24 34", "C3D8": ""}  # fmt: skip
    for kind, (points, faces, volume) in corners.items():
        middles = [(points[int(a) - 1] + points[int(b) - 1]) / 2 for a, b in edges[kind].split()]
        position = np.array([*points, *middles], dtype=float)
        node = np.arange(1, len(position) + 1)
        text = "*Node\n" + "".join(
            f"{n},{x},{y},{z}\n" for n, (x, y, z) in zip(node, position, strict=True)
        )
        text += (
            f"*Element, type={kind}, elset=a\n1,"
            + ",\n".join(map(str, node))
            + "\n*Surface, name=s\n"
        )
        text += "".join(f"a, S{k + 1}\n" for k in range(faces))
        (tmp_path / "solid.inp").write_text(text)
        shapes = ModeShapes(
            node,
            np.ones(1),
            np.ones(1),
            np.ones((len(node), 3, 1)) / 2,
            np.empty((len(node), 3, 0)),
        )
        model = modal_model("solid", read_mesh(tmp_path / "solid.inp"), shapes, 1.0)
        quadrature = surface_quadrature(model.position, model.cells)
        flux = np.einsum("qi,qi,q->", quadrature.position, quadrature.normal, quadrature.weight)
        assert flux / 3 == pytest.approx(volume), kind
