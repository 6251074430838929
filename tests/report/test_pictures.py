"""Rendered scenes show what they should: coloured spheres in their cells, warped modes."""

import numpy as np
import pytest

from pidpanel.coupon import geometry
from pidpanel.geometry.cells import SHAPES
from pidpanel.geometry.plane_mesh import boundary_edges
from pidpanel.report import pictures


def saturated(image):
    """Share of the pixels that are clearly coloured, neither grey nor white."""
    channels = image.astype(int)
    return float(np.mean(np.ptp(channels, axis=-1) > 60))


def scene(values, count=2):
    centres = geometry.cell_centres(6e-3, count)
    positions = np.array(
        [[x, y, height] for x, y in centres for height in (2e-3, 5e-3, 8e-3)], dtype=float
    )
    return pictures.spheres_picture(
        positions, np.full(len(positions), 3e-3), np.resize(values, len(positions)), (0.0, 1.0),
        outline=SHAPES["hexagon"].outline(6e-3), across_flats=6e-3, depth=12e-3, count=count, pixels=240,
    )  # fmt: skip


def test_spheres_are_seen_and_coloured_by_their_value():
    # red: positions left out of the scene; a fixed colour
    image = scene([0.0])
    assert image.std() > 10
    assert saturated(image) > 0.05
    slow, fast = scene([0.1]), scene([0.9])
    coloured = np.ptp(slow.astype(int), axis=-1) > 60
    difference = fast[coloured].astype(int).mean(axis=0) - slow[coloured].astype(int).mean(axis=0)
    assert difference[0] > 30  # plasma runs from blue to yellow
    assert difference[2] < -30


def test_cells_are_in_a_row_with_their_own_spheres():
    # red: every sphere moved like the first cell
    width, count = 6e-3, 5
    centres = geometry.cell_centres(width, count)
    offset = np.array([1e-3, -2e-3, 4e-3])
    moved, row = pictures.cells_in_a_row(np.pad(centres, ((0, 0), (0, 1))) + offset, width, count)
    assert moved - np.pad(row, ((0, 0), (0, 1))) == pytest.approx(np.tile(offset, (count, 1)))
    assert np.diff(row[:, 0]) == pytest.approx(np.full(4, pictures.ROW_PITCH * width))
    assert not row[:, 1].any()


def test_each_mode_has_its_own_picture_with_hills_and_valleys(basis):
    # red: the first shape drawn for all
    images = pictures.mode_pictures(
        basis.vertex_position, basis.cells, basis.shape_at_vertices[:, :2],
        boundary_edges(basis.cells), np.array([[0.75, 0.5]]), size=(200, 130),
    )  # fmt: skip
    red, blue = (
        np.array([np.mean(i[..., a].astype(int) - i[..., b] > 60) for i in images])
        for a, b in ((0, 2), (2, 0))
    )
    assert (red > 0.05).all()
    assert blue[0] < 0.01 < 0.05 < blue[1]  # (1, 1) has no valley, (2, 1) has one
