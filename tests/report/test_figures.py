"""Figures carry their units, one line a scenario, and say where damping is a continuation."""

import itertools
import re

import numpy as np
import pytest
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize, to_rgb

from pidpanel.report import (
    coupon_figures,
    layout,
    response_figures,
    sound_section,
    style,
)
from pidpanel.report.coupon_figures import (
    ACCELERATION,
    EQUIVALENT_DAMPING,
    FREQUENCY,
    Law,
)
from pidpanel.report.html import Chart, PageCurve
from pidpanel.report.layout import outline_curves
from pidpanel.report.response_figures import psd_unit

UNIT = re.compile(r"(, .*\S|\bcycle|\bpatch|\br)$")
LINES = np.geomspace(30, 2000, 300)


def panel(inside=None, title="DEM"):
    curves = [PageCurve("bare panel", 50 * LINES, style.BARE)]
    curves += [
        PageCurve(f"r = {fill}", LINES / fill, style.fill_colour(fill), inside=inside)
        for fill in (0.1, 0.5, 0.9)
    ]
    return Chart(title, LINES, psd_unit("326"), curves, "read at Γ = 312")


def drawn_axes(figure):
    return [axes for axes in figure.axes if axes.get_visible() and axes.axison]


def assert_units(figure):
    for axes in drawn_axes(figure):
        for label in (axes.get_xlabel(), axes.get_ylabel()):
            assert not label or UNIT.search(label), label
    left = [axes for axes in drawn_axes(figure) if axes.get_ylabel()]
    assert left


def test_a_psd_figure_has_one_line_a_scenario_and_a_unit_on_each_axis():
    figure = response_figures.charts_figure([panel(), panel(title="law")])
    assert [len(axes.lines) for axes in figure.axes] == [4, 4]
    assert figure.axes[0].get_ylabel() == "PSD at point 326, g²/Hz"
    assert {axes.get_xlabel() for axes in figure.axes} == {"frequency, Hz"}
    assert_units(figure)


def test_what_lies_outside_the_data_is_dashed_and_the_legend_says_so():
    inside = LINES > 200
    figure = response_figures.charts_figure([panel(inside)])
    dashed = [line for line in figure.axes[0].lines if line.get_linestyle() == "--"]
    assert len(dashed) == 3
    shown = np.isfinite(dashed[0].get_ydata())
    assert shown[LINES <= 200].all()
    assert not shown[LINES > 210].any()
    said = [text.get_text() for text in figure.legends[0].get_texts()]
    assert any("outside the range of its data" in text for text in said)
    whole = response_figures.charts_figure([panel()])
    assert not any("outside" in text.get_text() for text in whole.legends[0].get_texts())


def test_a_table_of_reductions_has_each_number_in_its_cell():
    values = np.array([[0.0, 1.26, 12.4], [-2.0, 0.04, 3.0]])
    centre = np.array([100.0, 125.9, 158.5])
    (table,) = response_figures.reduction_tables(
        centre, ["0.1", "0.9"], {("326", "DEM"): values}, "fill fraction r"
    )
    texts = [[text for text, _, _ in row] for row in table.cells]
    assert texts == [["0", "1.3", "12"], ["−2.0", "0", "3.0"]]
    assert table.columns[1:] == ["100", "125", "160"]
    dark = [[is_dark for _, _, is_dark in row] for row in table.cells]
    assert dark == [[False, False, True], [False, False, False]]


@pytest.mark.parametrize(
    ("x", "y", "panel_of", "axes", "lines"),
    [
        (FREQUENCY, EQUIVALENT_DAMPING, ACCELERATION, 3, 2),
        (ACCELERATION, EQUIVALENT_DAMPING, FREQUENCY, 2, 2),
    ],
)
def test_a_sweep_has_axes_a_value_and_error_bars_a_fill(cases, x, y, panel_of, axes, lines):
    figure = coupon_figures.sweep_figure(cases, x, y, panel_of)
    shown = drawn_axes(figure)
    assert len(shown) == axes
    assert all(len(one.containers) == lines for one in shown)
    assert_units(figure)


def test_law_and_bound_are_drawn_beside_the_cases(cases):
    figure = coupon_figures.sweep_figure(
        cases, FREQUENCY, EQUIVALENT_DAMPING, ACCELERATION,
        law=Law("law", lambda frequency, fill, _: 1000 * fill + 0 * frequency), bound="bound_n_s_m3",
    )  # fmt: skip
    lines = figure.axes[0].lines
    law = sorted(line.get_ydata()[0] for line in lines if line.get_linestyle() == "--")
    bound = sorted(line.get_ydata()[0] for line in lines if line.get_linestyle() == ":")
    assert law == pytest.approx([300, 700])
    assert bound == pytest.approx([1200, 2800])


def test_the_spectrum_has_units(study, bands):
    (fragment,) = sound_section.sound_section(study, bands).blocks
    spectrum = response_figures.charts_figure(fragment.values["spectrum"].charts)
    assert_units(spectrum)
    assert "dB re 20 µPa" in spectrum.axes[0].get_ylabel()


def test_the_same_numbers_give_the_same_bytes_and_no_date():
    first, second = (style.png(response_figures.charts_figure([panel()])) for _ in range(2))
    assert first == second
    assert b"tEXt" not in first


@pytest.mark.parametrize("across", [1, 2, 5])
def test_ticks_of_a_frequency_axis_do_not_run_into_each_other(across):
    with style.context():
        figure, grid = layout.figure_of_axes(across, across, 2.0, 0.0)
        for axes in grid:
            layout.frequency_axis(axes, 40.0, 2500.0)
        figure.draw_without_rendering()
        for axes in grid:
            boxes = [label.get_window_extent() for label in axes.get_xticklabels()]
            assert len(boxes) >= 2
            for first, second in itertools.pairwise(boxes):
                assert first.x1 < second.x0


@pytest.mark.parametrize("count", range(1, 13))
def test_rows_of_axes_are_full_or_have_the_legend_in_the_one_empty_place(count):
    with style.context():
        figure, grid = layout.figure_of_axes(count, 3, 2.0, 0.0)
        grid[0].plot([1, 2], label="a curve")
        layout.add_legend(figure, 3)
    empty = [axes for axes in figure.axes if not axes.axison]
    assert len(grid) == count and len(empty) <= 1
    assert [axes.get_legend() is not None for axes in empty] == [True] * len(empty)
    assert len(figure.legends) == 1 - len(empty)


def test_texts_on_colours_have_the_contrast_that_is_required():
    values = np.linspace(-1, 1, 201)[None]
    (row,) = response_figures.colour_table(
        "", [], [""], values, ScalarMappable(Normalize(-1, 1), "RdBu"), str
    ).cells
    for _, colour, is_dark in row:
        linear = [
            c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in to_rgb(colour)
        ]
        light = 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]
        contrast = 1.05 / (light + 0.05) if is_dark else (light + 0.05) / 0.05
        assert contrast >= 4.5  # WCAG 2, level AA


def test_outlines_of_rings_are_circles_and_those_of_rectangles_stay():
    turn = np.arange(8) * np.pi / 4 + np.array([0, 0.1] * 4)  # unequal chords
    wheel = np.stack([np.cos(turn), np.sin(turn)], axis=1)
    k = np.arange(8)
    cells = np.stack([k, np.roll(k, -1), 8 + np.roll(k, -1), 8 + k], axis=1)
    lines = outline_curves(np.concatenate([0.2 * wheel, wheel]), cells)
    radius = np.linalg.norm(np.concatenate(lines), axis=1)
    assert np.minimum(abs(radius - 1), abs(radius - 0.2)).max() < 1e-12
    assert len(lines) == 16 and min(map(len, lines)) > 2
    corners = np.array([[0.0, 0], [1, 0], [2, 0], [0, 1], [1, 1], [2, 1]])
    straight = outline_curves(corners, np.array([[0, 1, 4, 3], [1, 2, 5, 4]]))
    assert len(straight) == 6 and all(len(line) == 2 for line in straight)
