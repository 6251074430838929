"""What half the element size adds at single points: in closed form."""

import numpy as np
import pytest
import scipy.sparse as sp
import shapely

from pidpanel.panel.checks import free_edges, jaggedness, point_refinement_error, roughness
from pidpanel.panel.mesh import PanelMesh
from pidpanel.panel.point_supports import (
    added_compliance,
    angle_fraction,
    refinement_change,
    support_reactions,
)
from pidpanel.panel.section import ThinSection
from pidpanel.panel.supports import EdgeSupport, PointSupport, Supports


class Sheared:
    """A section whose stiffnesses differ along x and y."""

    bending = np.array([[80.0, 12.0, 0.0], [12.0, 20.0, 0.0], [0.0, 0.0, 16.0]])
    shear = np.diag([5e4, 2e5])


def grid(count):
    """The unit square in triangles."""
    line = np.linspace(0, 1, count + 1)
    vertices = np.array([(x, y) for y in line for x in line])
    lower = [i + j * (count + 1) for j in range(count) for i in range(count)]
    cells = [(k, k + 1, k + count + 2) for k in lower] + [
        (k, k + count + 2, k + count + 1) for k in lower
    ]
    return PanelMesh(vertices, np.array(cells), "triangles", {}, {})


def test_halving_a_foot_adds_the_logarithm_of_two_to_what_yields_there():
    # w = F ln(R/r)/(2π S) and Kelvin's β = M ln(R/r) (1/D + 1/D₆₆)/(4π), of a quarter turn four
    # times that
    force, moment = added_compliance(Sheared(), 1.0)
    assert force == pytest.approx((np.log(2.0) - np.log(1.0)) / (2 * np.pi * 1e5))
    assert moment == pytest.approx(np.log(2) / (4 * np.pi) * (1 / 40 + 1 / 16))
    assert added_compliance(Sheared(), 0.25) == pytest.approx((4 * force, 4 * moment))
    thin = ThinSection(50.0, 1.0, 0.2)
    assert added_compliance(thin, 1.0) == pytest.approx((0.0, np.log(2) / (200 * np.pi)))
    at_edge = np.log(2) / (200 * np.pi) * 2 * 4 / (3.2 * 0.8)
    assert added_compliance(thin, 0.5) == pytest.approx((0.0, at_edge))


@pytest.mark.parametrize(
    ("place", "share"),
    [
        ((0.5, 0.5), 1.0),
        ((0.5, 0.0), 0.5),
        ((1.0, 1.0), 0.25),
        ((0.0, 1.0), 0.25),
        ((0.3, 0.4), 1.0),
    ],
)
def test_a_panel_takes_all_half_or_a_quarter_of_a_turn_about_a_point(place, share):
    assert angle_fraction(grid(4), np.array(place)) == pytest.approx(share)


def test_a_held_coordinate_pulls_with_its_row_of_the_stiffness():
    mesh = grid(2)
    stiffness = sp.csr_array(np.arange(27.0 * 27).reshape(27, 27))
    points = {
        "middle": PointSupport((0.5, 0.5), "hold_down"),
        "corner": PointSupport((0.0, 0.0), "hinge"),
        "foot": PointSupport((1.0, 1.0), "hold_down", 0.1),
    }
    of_moments = np.array([np.arange(9, 18), np.arange(18, 27)])
    free = sp.csr_array(np.eye(27)[:, 1:])
    rows = support_reactions(mesh, Sheared(), points, stiffness, free, np.arange(9), of_moments)
    force, moment = added_compliance(Sheared(), 1.0)
    held = stiffness.toarray()[[4, 13, 22, 0]]
    scale = np.sqrt([force / 2, moment / 2, moment / 2, 2 * force])
    np.testing.assert_allclose(rows.toarray(), scale[:, None] * held[:, 1:])


def test_the_motion_near_a_mass_changes_as_far_as_the_mass_holds_the_panel():
    # a spring of the stiffness at which the panel yields holds half
    extent, size = 0.6, np.array([0.06])
    yields = np.log(100) / (2 * np.pi * 1e5)
    near = refinement_change(np.array([0.1]), size, extent)[0]
    at = [(0.0, 0.1), (5.0, 5.0)]
    for resistance, share in ((np.inf, 1.0), (1 / yields, 0.5), (0.1 / yields, 1 / 11)):
        change = point_refinement_error(
            extent, {(0.0, 0.0): resistance}, Sheared(), at, lambda _: 0.06
        )
        assert change == pytest.approx([share * near, 0.0])
    nearest = {(0.0, 0.0): np.inf, (0.0, 0.15): np.inf}
    change = point_refinement_error(extent, nearest, Sheared(), at, lambda _: 0.06)
    assert change[0] == pytest.approx(refinement_change(np.array([0.05]), size, extent)[0])
    thin = point_refinement_error(
        extent, {(0.0, 0.0): np.inf}, ThinSection(50.0, 1.0), at, lambda _: 0.06
    )
    assert thin == pytest.approx([near, 0.0])
    assert not point_refinement_error(extent, {}, Sheared(), at, lambda _: 0.06).any()


def test_whole_elements_reach_beyond_a_foot():
    # eight triangles about the middle, to √2 · 0.25 m; a polygon of twelve edges with the area of
    # its foot reaches 1.023 radii
    far = np.log(np.sqrt(2) * 0.25 / 0.3) - np.log(np.sqrt(np.pi / 6 / np.sin(np.pi / 6)))
    foot = PointSupport((0.5, 0.5), "hold_down", 0.3)
    hinge = PointSupport((0.5, 0.5), "hinge", 0.3)
    assert jaggedness(grid(4), Supports(points={"foot": foot})) == pytest.approx(far, abs=2e-3)
    assert jaggedness(grid(4), Supports(points={"foot": hinge})) == pytest.approx(
        0.3 * far, abs=1e-3
    )
    assert jaggedness(grid(4), Supports()) == 0
    point = PointSupport((0.5, 0.5), "hold_down")
    assert jaggedness(grid(4), Supports(points={"point": point})) == 0


def test_half_the_length_of_free_edges_counts_over_the_area():
    # 1 m of a supported square of 2 m
    edges = [EdgeSupport((0.0, 0.0), (1.0, 0.0), "free")]
    area = shapely.box(0, 0, 2, 2)
    assert free_edges(area, Supports(edges=edges)) == pytest.approx(1 / (2 * 4), rel=1e-5)


def test_the_roughest_foot_and_all_ends_within_edges_count():
    # sizes of 0.1 m over radii of 0.2 and 0.5 m; one end at a corner
    feet = {str(r): PointSupport((1.0, r), "hinge", r) for r in (0.2, 0.5)}
    edges = [EdgeSupport((0.0, 0.0), (1.0, 0.0), "clamped")]
    rough = roughness(
        shapely.box(0, 0, 2, 2), Supports("free", "free", edges, feet), lambda *_: 0.1
    )
    assert rough["feet"] == pytest.approx(0.5) and rough["ends"] == pytest.approx(0.1 / 2)
