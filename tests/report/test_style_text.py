"""Names and titles of a study appear in figures as they were typed."""

import pytest
from matplotlib.figure import Figure

from pidpanel.report import style
from pidpanel.report.layout import log_scale


@pytest.mark.parametrize(
    "typed", ["P $x$ {1}", r"$\frac{", r"a \$ b", r"100 % & $5", "$C_e$ of $x$", "{0/90}s <b>"]
)
def test_a_text_is_drawn_as_typed(typed):
    with style.context():
        figure = Figure()
        axes = figure.subplots()
        axes.set_title(typed)
        assert style.png(figure).startswith(b"\x89PNG")
        assert axes.title._preprocess_math(typed) == (typed, False)


def test_ticks_of_a_logarithmic_axis_are_numbers_and_powers_of_ten():
    with style.context():
        figure = Figure()
        axes = figure.subplots()
        axes.set_ylim(1e-7, 1e3)
        log_scale(axes)
        figure.draw_without_rendering()
        texts = {text.get_text() for text in axes.get_yticklabels()}
    assert {"10⁻⁷", "10⁻⁵", "0.001", "10", "1000"} <= texts


def test_two_decades_have_ticks_between_their_powers():
    with style.context():
        figure = Figure()
        axes = figure.subplots()
        axes.set_ylim(0.04, 3.0)
        log_scale(axes)
        figure.draw_without_rendering()
        texts = {text.get_text() for text in axes.get_yticklabels()}
    assert {"0.05", "0.1", "0.2", "0.5", "1", "2"} <= texts
