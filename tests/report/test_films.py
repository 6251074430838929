"""Rendered scenes show what they should: coloured spheres in their cells, warped modes."""

from types import SimpleNamespace

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg

from pidpanel.coupon import geometry
from pidpanel.geometry.cells import SHAPES
from pidpanel.geometry.plane_mesh import boundary_edges
from pidpanel.report import films, panel_figures, style

PACKING = SimpleNamespace(
    outline=SHAPES["hexagon"].outline(6e-3), across_flats=6e-3, depth=12e-3, count=5
)


def test_spheres_are_where_they_are_computed_and_coloured_by_their_speed():
    # red: positions or lift left out; a fixed colour
    places = np.array([[[0.0, 0.0, 3e-3], [films.PITCH * 6e-3, 0.0, 9e-3]]] * 2)
    first, lifted = films.draw_frames(
        PACKING, 2, places, np.full(2, 3e-3), np.array([[0.1, 0.9]] * 2), np.array([0.0, 1e-3])
    )
    first, lifted = (np.asarray(image).astype(int) for image in (first, lifted))
    rows, columns = np.nonzero(np.ptp(first, axis=-1) > 60)
    left, right = columns < first.shape[1] / 2, columns > first.shape[1] / 2
    assert rows[left].mean() > rows[right].mean()  # downwards in the picture
    slow, fast = (first[rows[side], columns[side]].mean(axis=0) for side in (left, right))
    assert fast[0] - slow[0] > 30 and fast[2] - slow[2] < -30  # plasma runs from blue to yellow
    up = np.nonzero(np.ptp(lifted, axis=-1) > 60)[0]
    assert rows.mean() - up.mean() > 5


def test_cells_are_in_a_row_with_their_own_spheres():
    # red: every sphere moved like the first cell
    centres = np.pad(geometry.cell_centres(6e-3, 5), ((0, 0), (0, 1)))
    offset = np.array([1e-3, -2e-3, 4e-3])
    inside, shift = films.in_a_row(centres + offset, PACKING, 4)
    assert inside.tolist() == [True] * 4 + [False]
    row = np.outer(np.arange(4), [films.PITCH * 6e-3, 0.0, 0.0])
    assert (centres + offset)[inside] + shift - row == pytest.approx(np.tile(offset, (4, 1)))


def test_each_mode_has_its_own_picture_with_hills_and_valleys(basis):
    # red: the first shape drawn for all
    with style.context():
        figure = panel_figures.shapes_figure(
            basis.vertex_position, basis.cells, basis.shape_at_vertices[:, :2],
            boundary_edges(basis.cells), np.array([[0.75, 0.5]]), ["1", "2"],
        )  # fmt: skip
        canvas = FigureCanvasAgg(figure)
        canvas.draw()
    drawn = np.asarray(canvas.buffer_rgba())
    images = [
        drawn[len(drawn) - int(box.y1) : len(drawn) - int(box.y0), int(box.x0) : int(box.x1)]
        for box in (axes.get_window_extent() for axes in figure.axes[:2])
    ]
    red, blue = (
        np.array([np.mean(i[..., a].astype(int) - i[..., b] > 60) for i in images])
        for a, b in ((0, 2), (2, 0))
    )
    assert (red > 0.05).all()
    assert blue[0] < 0.01 < 0.05 < blue[1]  # (1, 1) has no valley, (2, 1) has one


def test_the_case_of_the_film_succeeded_and_is_nearest_to_half_fill(cases):
    # red: the status not looked at
    cases["fill_fraction"] += 0.1
    nearest = films.nearest_case(cases)
    assert nearest == "r0.3_f100Hz_a12g"  # now of r = 0.4
    cases.loc[cases["case"] == nearest, "status"] = "NotSteady"
    assert films.nearest_case(cases) != nearest
