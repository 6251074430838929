"""The page as text: sections of pictures and templates into one self-contained file.

Images are in the page as base64, style and scripts are inline: the file needs no network and no
other file, and can be sent by mail. Curves are in it as numbers and drawn by uPlot
(``pages/uplot``, MIT licence) when their section is opened or printed.
"""

from __future__ import annotations

import base64
import json
import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from matplotlib.figure import Figure

from pidpanel.arrays import Array, Flags, Index
from pidpanel.provenance import durable
from pidpanel.report.style import BARE, RESOLUTION, Drawing
from pidpanel.report.templates import PAGES, environment

# uPlot as its authors ship it.
LIBRARIES = tuple(PAGES / "uplot" / name for name in ("uPlot.iife.min.js", "uPlot.min.css"))

SHOWN_PER_INCH = 100  # pixels per inch at which a page shows PNG files

BROAD = 640  # width from which a picture takes that of the page [pixel]

PIXELS = 1.6  # width of a curve on a screen over that in a figure [pixel/pt]

SAME = 0.005  # difference of ln of a curve that is less than a pixel
PASSES = 4  # each leaves out half of the lines at most

DIGITS = 4  # significant digits of a curve's values in the page: 0.01 % is finer than a pixel


def json_in_page(values: Any) -> str:
    r"""Return values for a script element, which ``</script>`` would end and ``<!--`` keep open.

    Examples
    --------
    >>> json_in_page({"name": "<!--<script>"})
    '{"name":"\\u003c!--\\u003cscript>"}'
    """
    text = json.dumps(values, separators=(",", ":"), ensure_ascii=False)
    return text.replace("<", "\\u003c")


@dataclass(frozen=True)
class PageCurve:
    """One curve of a `Chart`."""

    label: str
    values: Array  # (n_lines,) in the unit of the chart; not finite: a gap
    colour: str  # ``#rrggbb``
    line: Literal["solid", "dashed", "dotted"] = "solid"
    width: float | None = None  # [pt]; None for the usual one
    log_error: Array | None = None  # (n_lines,) standard error of ln of the values, drawn as a band
    inside: Flags | None = None  # (n_lines,) range of the damping's data; dashed outside
    error: Array | None = None  # (n_lines,) standard error in place of that of ln

    @property
    def band(self) -> tuple[Array, Array] | None:
        """Values plus and minus their standard error."""
        if self.error is not None:
            return self.values + self.error, self.values - self.error
        if self.log_error is None:
            return None
        factor = np.exp(self.log_error)
        return self.values * factor, self.values / factor

    @property
    def pixels(self) -> float:
        """Width on a screen [pixel]; the bare panel is thin among curves of several widths."""
        if self.width is None:
            return 1.2
        return 1.0 if self.colour == BARE else PIXELS * self.width


@dataclass(frozen=True)
class Chart:
    """Curves over frequency that a reader can zoom, read and switch on and off."""

    title: str
    frequency: Array  # (n_lines,) rising [Hz]
    unit: str  # quantity and unit, as on the axis
    curves: Sequence[PageCurve]  # the first is drawn over all others
    note: str = ""  # below the title of the figure
    is_log: bool = True  # whether the values have a logarithmic axis, and none below zero

    @property
    def json(self) -> str:
        """The chart for the script in the page."""
        chart, drawn = self.thinned(), []
        for curve in chart.curves:
            inside = np.ones(len(curve.values), bool) if curve.inside is None else curve.inside
            ends = np.flatnonzero(np.diff(~inside, prepend=False, append=False))
            drawn.append(
                {
                    "label": curve.label,
                    "colour": curve.colour,
                    "line": curve.line if inside.any() else "dashed",
                    "width": curve.pixels,
                    "values": self._rounded(curve.values),
                    "outside": ends.tolist(),
                    "band": [self._rounded(end) for end in curve.band or ()] or None,
                }
            )
        x = self._rounded(chart.frequency, 6)
        return json_in_page({"unit": self.unit, "log": self.is_log, "x": x, "curves": drawn})

    def thinned(self) -> Chart:
        """Return the chart at the lines without which a curve would be off by `SAME` or more."""
        lines = self._needed_lines()
        arrays = ("values", "log_error", "inside", "error")
        curves = []
        for curve in self.curves:
            fields = {name: getattr(curve, name) for name in arrays}
            cut = {name: v[lines] for name, v in fields.items() if v is not None}
            curves.append(replace(curve, **cut))
        return replace(self, frequency=self.frequency[lines], curves=curves)

    def _needed_lines(self) -> Index:
        """Return the lines that the curves need."""
        rows: list[Array] = [c.inside.astype(float) for c in self.curves if c.inside is not None]
        x, lines = np.log(self.frequency), np.arange(len(self.frequency))
        with np.errstate(all="ignore"):
            rows += [np.log(c.values) if self.is_log else c.values / np.ptp(c.values)
                     for c in self.curves]  # fmt: skip
            y = np.reshape(rows, (-1, len(lines)))
            for _ in range(PASSES):
                left, middle, right = lines[:-2:2], lines[1:-1:2], lines[2::2]
                share = (x[middle] - x[left]) / (x[right] - x[left])
                straight = (1 - share) * y[:, left] + share * y[:, right]
                # a comparison with NaN is false: gaps keep their ends
                spare = (np.abs(straight - y[:, middle]) < SAME).all(axis=0)
                lines = np.setdiff1d(lines, middle[spare])
        return lines

    def _rounded(self, values: Array, digits: int = DIGITS) -> list[float | None]:
        """Return values to some significant digits; None for a gap."""
        shown = np.isfinite(values) & ((values > 0) | (not self.is_log))
        return [
            float(f"{value:.{digits}g}") if is_shown else None
            for value, is_shown in zip(values.tolist(), shown.tolist(), strict=True)
        ]


@dataclass(frozen=True)
class ColourTable:
    """Numbers on colours."""

    title: str
    columns: Sequence[str]
    rows: Sequence[str]
    # (text, colour ``#rrggbb``, whether that is dark) by row and column
    cells: Sequence[Sequence[tuple[str, str, bool]]]


@dataclass(frozen=True)
class Picture:
    """An image with its caption, or its replacement in the page."""

    name: str  # anchor in the page and stem of the file
    drawn: bytes | Drawing
    # Also the text for readers who cannot see the image; empty where a template has it
    caption: str = ""
    # The same as numbers, in the place of the image
    charts: Sequence[Chart] = ()
    format: Literal["png", "webp"] = "png"
    # What readers without scripts see in place of the charts; of an image, a file as SVG
    vector: Drawing | None = None

    @property
    def is_image(self) -> bool:
        """Whether the page has an image of it."""
        return not self.charts

    @property
    def image(self) -> bytes:
        """The image."""
        return self.drawn if isinstance(self.drawn, bytes) else self.drawn.png

    @property
    def base64(self) -> str:
        """The image as text for a ``data:`` address."""
        return base64.b64encode(self.image).decode("ascii")

    @property
    def is_broad(self) -> bool:
        """Whether the picture takes the width of the page."""
        return self.is_image and (self.width or 0) > BROAD

    @property
    def width(self) -> int | None:
        """Width at which a PNG of `RESOLUTION` is shown [pixel]; None for no PNG."""
        image = self.image
        if not image.startswith(b"\x89PNG") or len(image) < 24:
            return None
        return round(int.from_bytes(image[16:20], "big") * SHOWN_PER_INCH / RESOLUTION)


def figure_picture(
    name: str, draw: Callable[..., Figure], *values: Any, caption: str = "", **options: Any
) -> Picture:
    """Return the figure that a function draws of values and options."""
    return Picture(name, Drawing(draw, *values, **options), caption)


@dataclass(frozen=True)
class Fragment:
    """A part of a page with a template of its own."""

    template: str  # file in ``pages``
    values: Mapping[str, Any]  # for it, by name; pictures among them


Block = Picture | Fragment


@dataclass(frozen=True)
class PageSection:
    """A heading and the blocks below it."""

    name: str  # anchor in the page
    title: str
    blocks: Sequence[Block]
    folded: bool = False  # whether the blocks are hidden behind the title

    @property
    def pictures(self) -> list[Picture]:
        """All pictures in order."""
        return list(pictures_of(self.blocks))

    def with_suffix(self, suffix: str) -> PageSection:
        """Return the section as one of several, each of something else.

        Examples
        --------
        >>> PageSection("coupon", "Coupon", []).with_suffix("steel")
        PageSection(name='coupon-steel', title='Coupon: steel', blocks=[], folded=False)
        """
        blocks = _with_suffix(self.blocks, suffix)
        return PageSection(f"{self.name}-{suffix}", f"{self.title}: {suffix}", blocks, self.folded)


def template_section(template: str, title: str, values: Mapping[str, Any]) -> PageSection:
    """Return the section that is a template filled with values, and has its name."""
    return PageSection(template.removesuffix(".html"), title, [Fragment(template, values)])


def _with_suffix(value: Any, suffix: str) -> Any:
    """Return blocks or values of a template with a suffix on the names of their pictures."""
    match value:
        case Picture():
            return replace(value, name=f"{value.name}_{suffix}")
        case Fragment():
            return replace(value, values=_with_suffix(value.values, suffix))
        case dict():
            return {key: _with_suffix(item, suffix) for key, item in value.items()}
        case list():
            return [_with_suffix(item, suffix) for item in value]
    return value


def pictures_of(value: Any) -> Iterator[Picture]:
    """Yield the pictures in blocks or in values of a template, in order."""
    match value:
        case Picture():
            yield value
        case Fragment():
            yield from pictures_of(list(value.values.values()))
        case dict():
            yield from pictures_of(list(value.values()))
        case list() | tuple():
            for item in value:
                yield from pictures_of(item)


CAVEATS = 3  # limitations at the head of a page; the others are in their part of it


@dataclass(frozen=True)
class Page:
    """A whole page."""

    title: str
    facts: Sequence[tuple[str, str]]  # (name, value): what was computed and with what
    sections: Sequence[PageSection]
    assumptions: Sequence[str] = ()  # where the source states nothing
    summary: Sequence[str] = ()  # further results in sentences
    warnings: Sequence[str] = ()  # limitations of the numbers in sentences
    claims: Fragment | None = None  # with their verdicts
    steps: Sequence[tuple[str, str]] = field(default=())  # (text, command) to reproduce the results
    answer: str = ""  # the result in a sentence or two, with its errors
    setting: str = ""  # what hangs where, and where the level was measured
    first: Sequence[Block] = ()  # shown below it: the table, the drawing, the curves that decide
    caveats: Sequence[str] = ()  # what a reader must know before using the answer
    noun: str = "panel"  # what the study is of

    @property
    def pictures(self) -> list[Picture]:
        """All pictures in order."""
        return [*pictures_of(self.first), *(p for s in self.sections for p in s.pictures)]

    @property
    def has_gap(self) -> bool:
        """Whether there is room next to the last of the first pictures, with two in a row."""
        return sum(not picture.is_broad for picture in pictures_of(self.first)) % 2 == 1


def render(page: Page, folder: Path = PAGES) -> str:
    """Return the page as one HTML text.

    Raises
    ------
    jinja2.UndefinedError
        If a template needs a variable that the page does not have.
    ValueError
        If two pictures or two sections have the same name.
    """
    for kind, names in (
        ("pictures", [picture.name for picture in page.pictures]),
        ("sections", [section.name for section in page.sections]),
    ):
        repeated = sorted({name for name in names if names.count(name) > 1})
        if repeated:
            raise ValueError(f"{kind} with the same name: {', '.join(repeated)}")
    libraries = {path.name: path.read_text(encoding="utf-8") for path in LIBRARIES}
    text = environment(folder).get_template("page.html").render(page=page, libraries=libraries)
    return re.sub(r"\b([Tt]he|[Bb]are)(\s+)panel", rf"\1\2{page.noun}", text)


def write_page(page: Page, file: Path, figures: Path) -> None:
    """Write a page, and each of its images as ``<name>.<format>`` into a folder, some as SVG."""
    figures.mkdir(exist_ok=True)
    for picture in page.pictures:
        if picture.is_image:
            (figures / f"{picture.name}.{picture.format}").write_bytes(picture.image)
            if picture.vector is not None:
                picture.vector.write(figures / f"{picture.name}.svg", page.title)
    durable.write_text(file, render(page))


def write_figures(page: Page, formats: Sequence[str], figures: Path) -> None:
    """Write the figures of a page with its title as PNG, SVG or PDF; films are left out."""
    figures.mkdir(parents=True, exist_ok=True)
    for picture in page.pictures:
        if isinstance(picture.drawn, Drawing):
            for name in formats:
                picture.drawn.write(figures / f"{picture.name}.{name}", page.title)
