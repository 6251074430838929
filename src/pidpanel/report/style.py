"""Colours and line styles: one look per fill, patch and sound level in all figures.

The colours are distinct for the common kinds of colour blindness: fills run through viridis
(dark is empty), sound levels through plasma, patches take the set of Okabe and Ito (2008). The
bare panel is black throughout. Nothing is set for the process: a `Drawing` draws within `context`.
"""

import re
from collections.abc import Callable, Iterator, Sequence
from contextlib import AbstractContextManager
from functools import cached_property, partial
from io import BytesIO
from pathlib import Path
from typing import Any

import matplotlib as mpl
import numpy as np
from matplotlib import colors, rc_params_from_file
from matplotlib.artist import Artist
from matplotlib.axis import Axis
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from matplotlib.text import Text
from PIL import Image

RESOLUTION = 180  # dots per inch of the PNG files

BARE = "#000000"  # colour of the bare panel

# Mathematics that figures write themselves; a dollar of any other text is a dollar.
_OURS = re.compile(r"(\$(?:[CEm]_[ade]|m A\^2 \\omega\^2|\\mathdefault\{.*?\})\$)")

# Colours of patches, and of anything else without an order.
PLACES = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
MARKERS = ("o", "s", "^", "D", "v", "P", "X")  # markers of lines, in addition to colours

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


def as_typed(text: str) -> str:
    r"""Return a text that matplotlib draws as it is, but for the symbols of the figures.

    Examples
    --------
    >>> as_typed("$C_e$ of $50, $x$")
    '$C_e$ of \\$50, \\$x\\$'
    """
    parts = _OURS.split(text)
    return "".join(p if n % 2 else p.replace("$", r"\$") for n, p in enumerate(parts))


def set_as_typed(figure: Figure) -> None:
    """Make names and titles of a study in a figure appear as they were typed.

    Ticks have numbers, or names that are `as_typed` already: to ask for them makes them twice.
    """

    def texts(artist: Artist) -> Iterator[Text]:
        for child in artist.get_children():
            if isinstance(child, Text):
                yield child
            elif isinstance(child, Axis):
                yield child.label
            else:
                yield from texts(child)

    for text in texts(figure):
        if "$" in text.get_text():
            text.set_text(as_typed(text.get_text()))


class Drawing:
    """A figure that is drawn when it is needed."""

    def __init__(self, draw: Callable[..., Figure], *values: Any, **options: Any) -> None:
        self._draw = partial(draw, *values, **options)

    @cached_property
    def png(self) -> bytes:
        """The figure as PNG."""
        with context():
            return png(self._draw())

    def write(self, path: Path) -> None:
        """Write the figure as PNG, SVG or PDF, by the end of the path."""
        if path.suffix == ".png":
            path.write_bytes(self.png)
            return
        date = {".svg": "Date", ".pdf": "CreationDate"}[path.suffix]
        with context():
            figure = self._draw()
            set_as_typed(figure)
            figure.savefig(path, metadata={date: None})


def png(figure: Figure) -> bytes:
    """Return the figure as PNG, the same bytes from the same numbers; texts appear as typed."""
    set_as_typed(figure)
    figure.set_dpi(RESOLUTION)
    canvas = FigureCanvasAgg(figure)
    canvas.draw()  # `savefig` draws twice
    buffer = BytesIO()
    image = Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB")
    image.save(buffer, format="png", compress_level=6)  # `optimize` takes seven times as long
    return buffer.getvalue()
