"""Truths of the meshes: numbering, patches, points, and what they refuse."""

import os
import signal
from concurrent.futures import ThreadPoolExecutor

import gmsh
import meshio
import numpy as np
import pytest

from pidpanel.geometry.polygon import Polygon, Rectangle
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.mesh import gmsh_session, read_mesh
from pidpanel.panel.triangles import mesh_triangles, reentrant_corners

SIZE = (1.5, 1.0)
ELEMENTS = (30, 20)
OUTLINE = Polygon(((0.0, 0.0), (1.5, 0.0), (1.5, 1.0), (0.0, 1.0)))
L_SHAPE = Polygon(((0.0, 0.0), (1.5, 0.0), (1.5, 0.5), (0.75, 0.5), (0.75, 1.0), (0.0, 1.0)))
PID = Rectangle((0.75, 0.50), (0.2, 0.2))


def areas(mesh):
    """Areas of the cells by the shoelace formula."""
    x, y = mesh.vertices[mesh.cells].transpose(2, 0, 1)
    return 0.5 * np.sum(x * np.roll(y, -1, axis=1) - np.roll(x, -1, axis=1) * y, axis=1)


def test_the_file_holds_the_grid_points_under_the_numbers_of_the_paper(paper_path, paper_mesh):
    with gmsh_session():
        gmsh.open(str(paper_path))
        for number, position in {326: (0.75, 0.5), 189: (0.1, 0.3), 318: (0.35, 0.5)}.items():
            found, _, _, _ = gmsh.model.mesh.getNode(number)
            np.testing.assert_allclose(found, (*position, 0.0), atol=1e-12)


def test_patches_of_the_paper_are_16_cells_each_and_lie_where_they_should(paper_mesh):
    boxes = {
        "PID-1": ((0.65, 0.40), (0.85, 0.60)),
        "PID-2": ((0.00, 0.20), (0.20, 0.40)),
        "PID-3": ((0.25, 0.40), (0.45, 0.60)),
    }
    assert paper_mesh.cells.shape == (600, 4)
    for name, (lower, upper) in boxes.items():
        corners = paper_mesh.vertices[paper_mesh.cells[paper_mesh.patch_cells[name]]]
        assert len(corners) == 16
        np.testing.assert_allclose(corners.min(axis=(0, 1)), lower, atol=1e-12)
        np.testing.assert_allclose(corners.max(axis=(0, 1)), upper, atol=1e-12)


def test_the_file_names_panel_and_patches_as_physical_groups(paper_path, paper_mesh):
    groups = {name: int(dim) for name, (_, dim) in meshio.read(paper_path).field_data.items()}
    assert groups == {"panel": 2, "PID-1": 2, "PID-2": 2, "PID-3": 2}


@pytest.mark.parametrize("kind", ["quadrilaterals", "triangles"])
def test_overlapping_patches_and_coinciding_points_keep_their_own_groups(tmp_path, kind):
    patches = {"A": PID, "B": Rectangle((0.75, 0.55), (0.3, 0.2))}
    points = {"centre": (0.75, 0.5), "326": (0.75, 0.5), "corner": (0.0, 0.0), "rim": (0.85, 0.45)}
    if kind == "quadrilaterals":
        mesh = mesh_quadrilaterals(tmp_path / "m.msh", SIZE, ELEMENTS, patches, points)
    else:
        mesh = mesh_triangles(tmp_path / "m.msh", OUTLINE, 0.1, patches, points)
    assert mesh.cell_kind == kind
    area = areas(mesh)
    # rounding of coordinates over some hundred cells
    assert area.sum() == pytest.approx(1.5, rel=1e-10)
    assert area.min() > 0
    assert area[mesh.patch_cells["A"]].sum() == pytest.approx(0.04, rel=1e-10)
    assert area[mesh.patch_cells["B"]].sum() == pytest.approx(0.06, rel=1e-10)
    both = np.intersect1d(mesh.patch_cells["A"], mesh.patch_cells["B"])
    assert area[both].sum() == pytest.approx(0.2 * 0.15, rel=1e-10)
    assert mesh.points == points
    assert [mesh.patches_at(at) for at in points.values()] == [["A", "B"]] * 2 + [[], ["A", "B"]]


def test_triangles_fill_an_l_shape_with_edges_of_the_asked_length(tmp_path):
    mesh = mesh_triangles(tmp_path / "l.msh", L_SHAPE, 0.1, {}, {"p": (0.3, 0.3)}, corner_size=0.1)
    assert areas(mesh).sum() == pytest.approx(1.5 - 0.75 * 0.5, rel=1e-10)
    corners = mesh.vertices[mesh.cells]
    length = np.linalg.norm(corners - np.roll(corners, 1, axis=1), axis=2)
    # gmsh keeps the mean to a few per cent and single edges within a factor of two
    assert 0.09 < length.mean() < 0.11
    assert 0.05 < length.min() and length.max() < 0.2


def test_the_mesh_returned_is_the_mesh_in_the_file(paper_path, paper_mesh):
    again = read_mesh(paper_path, ["PID-1"], {"326": (0.75, 0.5)})
    np.testing.assert_array_equal(again.vertices, paper_mesh.vertices)
    np.testing.assert_array_equal(again.cells, paper_mesh.cells)
    np.testing.assert_array_equal(again.patch_cells["PID-1"], paper_mesh.patch_cells["PID-1"])
    assert again.points == {"326": (0.75, 0.5)}


def test_cells_that_are_no_squares_lie_in_their_patch_and_carry_their_point(tmp_path):
    # cells of 1 m x 0.25 m
    patch = Rectangle((3.0, 0.375), (2.0, 0.25))
    mesh = mesh_quadrilaterals(
        tmp_path / "m.msh", (6.0, 1.0), (6, 4), {"P": patch}, {"7": (5.0, 0.75)}
    )
    np.testing.assert_allclose(areas(mesh), 0.25)
    assert len(mesh.cells) == 24
    centres = mesh.vertices[mesh.cells[mesh.patch_cells["P"]]].mean(axis=1)
    np.testing.assert_allclose(centres, [[2.5, 0.375], [3.5, 0.375]])


def turned(shape, scale=1.0, degrees=20.0):
    """A polygon turned about the origin, so that x and y cannot be taken for one another."""
    c, s = scale * np.cos(np.radians(degrees)), scale * np.sin(np.radians(degrees))
    return Polygon(tuple((c * x - s * y, s * x + c * y) for x, y in shape.corners.tolist()))


def same_places(found, expected):
    found, expected = (np.array(sorted(map(tuple, places))) for places in (found, expected))
    np.testing.assert_allclose(found, expected, atol=1e-12)


@pytest.mark.parametrize("scale", [0.1, 10.0])
@pytest.mark.parametrize("back", [False, True])
def test_an_l_has_one_reentrant_corner_whichever_way_it_is_drawn(scale, back):
    shape = turned(L_SHAPE, scale)
    corner = shape.corners[3]
    if back:
        shape = Polygon(shape.points[::-1])
    same_places(reentrant_corners([shape]), [corner])


@pytest.mark.parametrize("back", [False, True])
def test_round_holes_the_corners_are_reentrant_but_for_those_that_are_of_the_outline(back):
    # an L as a hole leaves five
    outline = turned(Rectangle((0.5, 0.5), (9.0, 9.0)))
    hole, other = turned(L_SHAPE), turned(Rectangle((-1.0, -1.0), (0.5, 0.5)))
    expected = [*np.delete(hole.corners, 3, axis=0), *other.corners]
    if back:
        hole, other = Polygon(hole.points[::-1]), Polygon(other.points[::-1])
    same_places(reentrant_corners([outline, hole, other]), expected)


@pytest.mark.parametrize(("asked", "smallest"), [(None, 2e-3 * 0.25), (0.01, 0.01)])
def test_elements_shrink_to_what_is_asked_of_a_reentrant_corner(tmp_path, asked, smallest):
    # to a factor of two, which gmsh keeps
    mesh = mesh_triangles(tmp_path / "l.msh", L_SHAPE, 0.25, {}, {}, corner_size=asked)
    corner = np.flatnonzero(np.linalg.norm(mesh.vertices - (0.75, 0.5), axis=1) < 1e-9).item()
    edges = mesh.cells[(mesh.cells == corner).any(axis=1)]
    length = np.linalg.norm(mesh.vertices[np.unique(edges)] - (0.75, 0.5), axis=1)
    nearest = np.sort(length)[1]
    assert smallest / 2 < nearest < 2 * smallest


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            {"patches": {"A": Rectangle((0.1, 0.1), (0.3, 0.1))}},
            "patch 'A' = [-0.05, 0.25] x [0.05, 0.15] m leaves the panel;"
            " allowed is [0, 1.5] x [0, 1] m",
        ),
        (
            {"patches": {"A": Rectangle((0.1001, 0.1), (0.2, 0.2))}},
            "patch 'A' = [0.0001, 0.2001] x [0, 0.2] m: its line at 0.0001 m is 0.0001 m from"
            " another; allowed is the same place or at least 0.0005 m",
        ),
        (
            {"anchors": {"7": (1.6, 0.5)}},
            "point '7' = (1.6, 0.5) m leaves the panel; allowed is [0, 1.5] x [0, 1] m",
        ),
        (
            {"patches": {"A": PID}, "points": {"A": (0.0, 0.0)}},
            "'A' names both a patch and a point; names must differ",
        ),
        (
            {"points": {"panel": (0.0, 0.0)}},
            "'panel' names the whole panel; no patch or point may have it",
        ),
    ],
)
def test_quadrilaterals_refuse(tmp_path, arguments, message):
    given = {"size": SIZE, "elements": ELEMENTS, "patches": {}, "points": {}} | arguments
    with pytest.raises(ValueError) as caught:
        mesh_quadrilaterals(tmp_path / "m.msh", **given)
    assert str(caught.value) == message


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (
            {"patches": {"A": Rectangle((0.75, 0.5), (0.2, 0.2))}},
            "patch 'A' = [0.65, 0.85] x [0.4, 0.6] m leaves the panel; allowed is the inside of"
            " the outline (0, 0), (1.5, 0), (1.5, 0.5), (0.75, 0.5), (0.75, 1), (0, 1) m",
        ),
        (
            {"points": {"7": (1.0, 0.75)}},
            "point '7' = (1, 0.75) m leaves the panel; allowed is the inside of the outline"
            " (0, 0), (1.5, 0), (1.5, 0.5), (0.75, 0.5), (0.75, 1), (0, 1) m",
        ),
        ({"outline": Polygon(OUTLINE.points[:2])}, "outline has 2 corners; it needs at least 3"),
        (
            {"outline": Polygon(((0, 0), (1, 1), (2, 2)))},
            "outline (0, 0), (1, 1), (2, 2) m encloses no area",
        ),
        (
            {"outline": Polygon(((0, 0), (1, 1), (1, 0), (0, 2)))},
            "outline crosses itself: the edge from (0, 0) m meets the edge from (1, 0) m",
        ),
    ],
)
def test_triangles_refuse(tmp_path, arguments, message):
    given = {"outline": L_SHAPE, "element_size": 0.1, "patches": {}, "points": {}} | arguments
    with pytest.raises(ValueError) as caught:
        mesh_triangles(tmp_path / "m.msh", **given)
    assert str(caught.value) == message
    assert not gmsh.isInitialized()


def test_gmsh_leaves_no_state_no_words_and_no_signal_handler(tmp_path, capfd):
    handler = signal.getsignal(signal.SIGINT)
    first = mesh_triangles(tmp_path / "1.msh", OUTLINE, 0.2, {"A": PID}, {})
    second = mesh_triangles(tmp_path / "2.msh", OUTLINE, 0.2, {"A": PID}, {})
    assert not gmsh.isInitialized()
    assert signal.getsignal(signal.SIGINT) is handler
    assert capfd.readouterr() == ("", "")
    assert (tmp_path / "1.msh").read_bytes() == (tmp_path / "2.msh").read_bytes()
    np.testing.assert_array_equal(first.cells, second.cells)


def test_meshes_can_be_made_off_the_main_thread(tmp_path):
    with ThreadPoolExecutor(1) as pool:
        mesh = pool.submit(mesh_triangles, tmp_path / "m.msh", OUTLINE, 0.5, {}, {}).result()
    assert mesh.cells.shape[1] == 3


@pytest.mark.parametrize("in_a_thread", [False, True])
def test_a_closed_pipe_is_an_error_after_gmsh_too(in_a_thread):
    def mesh_and_write():
        with gmsh_session():
            pass
        reader, writer = os.pipe()
        os.close(reader)
        with pytest.raises(BrokenPipeError):
            os.write(writer, b"x")
        os.close(writer)

    if in_a_thread:
        with ThreadPoolExecutor(1) as pool:
            pool.submit(mesh_and_write).result()
    else:
        mesh_and_write()


def test_an_open_gmsh_of_somebody_else_is_left_alone(tmp_path):
    with gmsh_session():
        with pytest.raises(RuntimeError, match="gmsh is already open in this process"):
            mesh_triangles(tmp_path / "m.msh", OUTLINE, 0.5, {}, {})
        assert gmsh.isInitialized()
