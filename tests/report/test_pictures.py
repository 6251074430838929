"""Rendered scenes show what they should: coloured spheres in their cells, warped modes."""

from io import BytesIO

import numpy as np
import pytest
from matplotlib.figure import Figure
from PIL import Image

from pidpanel.coupon import geometry
from pidpanel.geometry.cells import SHAPES
from pidpanel.report import films, style
from pidpanel.report.layout import draw_field


def saturated(image):
    """Share of the pixels that are clearly coloured, neither grey nor white."""
    channels = image.astype(int)
    return float(np.mean(np.ptp(channels, axis=-1) > 60))


def scene(values, count=2):
    centres = geometry.cell_centres(6e-3, count)
    positions = np.array(
        [[x, y, height] for x, y in centres for height in (2e-3, 5e-3, 8e-3)], dtype=float
    )
    row = films.CellRow(SHAPES["hexagon"].outline(6e-3), 6e-3, 12e-3, count)
    _, shift = row.take(positions, count)
    colours = np.resize(values, (1, len(positions)))
    (image,) = films.spheres_film(
        [positions + shift], np.full(len(positions), 3e-3), colours, (0.0, 1.0), row,
        lift=np.zeros(1), pixels=240,
    )  # fmt: skip
    return image


def test_spheres_are_seen_and_coloured_by_their_value():
    image = scene([0.0])
    assert image.std() > 10
    assert saturated(image) > 0.05
    slow, fast = scene([0.1]), scene([0.9])
    coloured = np.ptp(slow.astype(int), axis=-1) > 60
    difference = fast[coloured].astype(int).mean(axis=0) - slow[coloured].astype(int).mean(axis=0)
    assert difference[0] > 30  # plasma runs from blue to yellow
    assert difference[2] < -30


def test_a_cell_that_moves_up_is_higher_in_its_own_frame():
    row = films.CellRow(SHAPES["hexagon"].outline(6e-3), 6e-3, 12e-3, 1)
    images = films.spheres_film(
        [np.array([[0.0, 0.0, 5e-3]])] * 4, np.array([3e-3]), np.zeros((4, 1)), (0.0, 1.0), row,
        lift=np.array([0.0, 2e-3, 2e-3, -2e-3]), pixels=120,
    )  # fmt: skip
    rows = [np.flatnonzero((np.ptp(i.astype(int), axis=-1) > 60).any(axis=1)) for i in images]
    heights = [-each.mean() for each in rows]
    assert heights[1] == heights[2] > heights[0] + 5
    assert heights[0] - heights[3] == pytest.approx(heights[1] - heights[0], abs=1)


def test_cells_are_in_a_row_with_their_own_spheres():
    width, count, drawn = 6e-3, 5, 4
    centres = np.pad(geometry.cell_centres(width, count), ((0, 0), (0, 1)))
    offset = np.array([1e-3, -2e-3, 4e-3])
    row = films.CellRow(np.zeros((6, 2)), width, 12e-3, drawn)
    inside, shift = row.take(centres + offset, count)
    assert inside.tolist() == [True] * drawn + [False]
    moved = (centres + offset)[inside] + shift
    assert moved - row.centres == pytest.approx(np.tile(offset, (drawn, 1)))
    assert np.diff(row.centres[:, 0]) == pytest.approx(np.full(3, films.ROW_PITCH * width))
    assert not row.centres[:, 1:].any()


def test_the_case_of_the_film_succeeded_and_is_nearest_to_half_fill(cases):
    cases["fill_fraction"] += 0.1
    nearest = films.nearest_case(cases)
    assert nearest == "r0.3_f100Hz_a12g"  # now of r = 0.4
    cases.loc[cases["case"] == nearest, "status"] = "NotSteady"
    assert films.nearest_case(cases) != nearest


def shares_of_the_bar(figure):
    """Share of the coloured pixels of each field whose colours are those of its colour bar."""
    pixels = np.asarray(Image.open(BytesIO(style.png(figure))).convert("RGB"))

    def inside(axes):
        box = axes.get_window_extent()
        top, bottom = len(pixels) - int(box.y1), len(pixels) - int(box.y0)
        return pixels[top + 2 : bottom - 2, int(box.x0) + 2 : int(box.x1) - 2].reshape(-1, 3)

    for axes in figure.axes:
        bar = getattr(axes.collections[0], "colorbar", None) if axes.collections else None
        if bar is not None and axes is not bar.ax:
            drawn, known = inside(axes), {tuple(c) for c in inside(bar.ax).tolist()}
            drawn = drawn[np.ptp(drawn.astype(int), axis=1) > 20]  # neither lines nor paper
            yield np.mean([tuple(colour) in known for colour in drawn.tolist()])


def test_a_map_has_the_colours_of_its_bar_and_no_others():
    # on two elements only, whose corners have the colours of both ends
    corners = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1]])
    values, cells = np.array([-1.0, 1, -1, 1]), np.array([[0, 1, 2], [0, 2, 3]])
    with style.context():
        figure = Figure(figsize=(3, 2))
        axes = figure.subplots()
        axes.set(xlim=(0, 1), ylim=(0, 1))
        figure.colorbar(draw_field(axes, corners, cells, values, "RdBu_r", (-1.0, 1.0)), ax=axes)
        (share,) = shares_of_the_bar(figure)
    assert share > 0.98  # the rest are grid lines
    drawn = figure.axes[0].collections[0].get_array()
    assert -1 <= drawn.min() < -0.95 and 0.95 < drawn.max() <= 1


def test_a_map_has_no_hole_where_an_element_has_the_highest_value():
    corners = np.array([[0.0, 0], [1, 0], [1, 1], [0, 1], [2, 0], [2, 1]])
    cells = np.array([[0, 1, 2, 3], [1, 4, 5, 2]])
    with style.context():
        figure = Figure(figsize=(2, 1), frameon=False)
        axes = figure.add_axes((0, 0, 1, 1), xlim=(0, 2), ylim=(0, 1))
        axes.set_axis_off()
        draw_field(axes, corners, cells, np.array([1.0, 1, 1, 1, -1, -1]), "RdBu_r", (-1.0, 1.0))
        pixels = np.asarray(Image.open(BytesIO(style.png(figure))).convert("RGB"))
    # the left half has the colour of the highest value
    half = pixels[5:-5, 5 : pixels.shape[1] // 2 - 5].reshape(-1, 3)
    assert len(np.unique(half, axis=0)) == 1 and half[0, 0] < 120
