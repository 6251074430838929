"""Colours and line styles: one look per fill, patch and sound level in all figures.

The colours are distinct for the common kinds of colour blindness: fills run through viridis
(dark is empty), sound levels through plasma, patches take the set of Okabe and Ito (2008). The
bare panel is black throughout. Nothing is set for the process: a `Drawing` draws within `context`.
"""

import re
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from functools import cached_property, partial
from io import BytesIO, StringIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import colors, rc_params_from_file
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

RESOLUTION = 180  # dots per inch of the PNG files

BARE = "#000000"  # colour of the bare panel

# Colours of patches, and of anything else without an order.
PLACES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")  # markers of lines, in addition to colours

SVG_FACTS = ("Creator", "Date", "Format", "Type")  # left out of an SVG in the page

_RC = rc_params_from_file(Path(__file__).with_name("pages") / "figures.mplstyle", True, False)


def context() -> AbstractContextManager[None]:
    """Return a context with the settings of matplotlib for the figures, whatever a user's are."""
    return mpl.rc_context({**mpl.rcParamsDefault, **_RC})


def fill_colour(fill_fraction: float) -> str:
    """Return the colour of a fill fraction, 0 to 1; the pale end of viridis is left out."""
    return colors.to_hex(mpl.colormaps["viridis"](0.05 + 0.83 * fill_fraction))


def place_colour(place: str, places: Sequence[str]) -> str:
    """Return the colour of a patch among all patches of the panel."""
    return PLACES[list(places).index(place) % len(PLACES)]


def level_colour(level: float, levels: Sequence[float]) -> str:
    """Return the colour of a sound level among all levels of a family, dark for the lowest."""
    rank = sorted(levels).index(level) / max(1, len(levels) - 1)
    return colors.to_hex(mpl.colormaps["plasma"](0.05 + 0.72 * rank))


def pale(colour: str) -> str:
    """Return a colour half way to white.

    Examples
    --------
    >>> pale("#0072B2")
    '#80b8d8'
    """
    red, green, blue = colors.to_rgb(colour)
    return colors.to_hex(((1 + red) / 2, (1 + green) / 2, (1 + blue) / 2))


class Drawing:
    """A figure that is drawn when it is needed."""

    def __init__(self, draw: Callable[..., Figure], *values: Any, **options: Any) -> None:
        self._draw = partial(draw, *values, **options)

    @cached_property
    def png(self) -> bytes:
        """The figure as PNG."""
        with context():
            return png(self._draw())

    @property
    def svg(self) -> str:
        """The figure as an SVG element with texts as texts."""
        buffer = StringIO()
        with context(), mpl.rc_context({"svg.fonttype": "none"}):
            self._draw().savefig(buffer, format="svg", metadata=dict.fromkeys(SVG_FACTS))
        element = "<svg" + buffer.getvalue().partition("<svg")[2]
        return re.sub(r"(\.\d\d)\d+", r"\1", element)  # a hundredth of a point

    def write(self, path: Path, title: str) -> None:
        """Write the figure below a title as PNG, SVG or PDF, by the end of the path."""
        date = {".png": "Software", ".svg": "Date", ".pdf": "CreationDate"}[path.suffix]
        with context():
            figure = self._draw()
            figure.text(0.0, 1.0, title, va="bottom", fontweight="bold")
            look: dict[str, Any] = {"dpi": RESOLUTION, "bbox_inches": "tight"}
            figure.savefig(path, metadata={date: None}, **look)


def png(figure: Figure) -> bytes:
    """Return the figure as PNG of at most 256 colours, the same bytes from the same numbers."""
    figure.set_dpi(RESOLUTION)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # `savefig` draws twice
    image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    buffer = BytesIO()
    # half the bytes and half the time of full colours
    palette = image.quantize(method=Image.Quantize.FASTOCTREE, dither=Image.Dither.NONE)
    # the palette has 254 for white
    palette.putpalette([255 if level > 252 else level for level in palette.getpalette() or []])
    palette.save(buffer, format="png", compress_level=6)
    return buffer.getvalue()
