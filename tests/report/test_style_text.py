"""Names and titles of a study appear in figures as they were typed."""

import pytest
from matplotlib.figure import Figure

from pidpanel.report import style


@pytest.mark.parametrize(
    "typed", ["P $x$ {1}", r"$\frac{", r"a \$ b", r"100 % & $5", "$C_e$ of $x$", "{0/90}s <b>"]
)
def test_a_text_is_drawn_as_typed_and_our_symbols_as_symbols(typed):
    with style.context():
        figure = Figure()
        axes = figure.subplots()
        axes.set_title(typed)
        axes.set_yscale("log")
        axes.set_ylabel("$C_e$, N s/m³")
        assert style.png(figure).startswith(b"\x89PNG")
        text = axes.title.get_text()
        own = "$C_e$" if "$C_e$" in typed else ""
        drawn, is_math = axes.title._preprocess_math(text.replace(own, "") if own else text)
        assert not is_math
        assert drawn == typed.replace(own, "") if own else drawn == typed
        assert axes.title._preprocess_math(text)[1] is (True if own else False)
        assert axes.yaxis.label._preprocess_math(axes.get_ylabel())[1] is True
