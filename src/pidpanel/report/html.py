"""The page as text: sections of paragraphs, pictures and tables into one self-contained file.

Images are in the page as base64, style and scripts are inline: the file needs no network and no
other file, and can be sent by mail. Curves that a reader may zoom and switch are drawn by uPlot
(``templates/report/uplot``, MIT licence); where there are no scripts, and in print, the picture of
the same curves stands in their place.
"""

from __future__ import annotations

import base64
import json
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any, Literal

import jinja2
import numpy as np

from pidpanel.arrays import Array
from pidpanel.paths import TEMPLATES

TEMPLATE = TEMPLATES / "report"

LIBRARIES = tuple(TEMPLATE / "uplot" / name for name in ("uPlot.iife.min.js", "uPlot.min.css"))
"""uPlot as its authors ship it."""

RESOLUTION, SHOWN_PER_INCH = 180, 100
"""Dots per inch of the PNG files, and pixels per inch at which a page shows them."""

BROAD = 640
"""Width from which a picture takes that of the page [pixel]."""

DIGITS = 4
"""Significant digits of a curve's values in the page: 0.01 % is finer than a pixel."""


@dataclass(frozen=True)
class Paragraph:
    """Plain text."""

    text: str
    kind: Literal["paragraph"] = "paragraph"


@dataclass(frozen=True)
class PageCurve:
    """One curve of a `Chart`.

    Attributes
    ----------
    label
        Name in the legend.
    values
        In the unit of the chart, shape ``(n_lines,)``; what is not finite or not positive is a
        gap.
    colour
        Colour of the line, as ``#rrggbb``.
    dashed
        Whether the line is dashed.
    width
        Width of the line [pixel].
    log_error
        Standard error of ln of the values, shape ``(n_lines,)``, drawn as a band; None for none.
    """

    label: str
    values: Array
    colour: str
    dashed: bool = False
    width: float = 1.2
    log_error: Array | None = None


@dataclass(frozen=True)
class Chart:
    """Curves over frequency that a reader can zoom, read and switch on and off.

    Attributes
    ----------
    title
        What is above the curves.
    frequency
        Rising frequencies [Hz], shape ``(n_lines,)``.
    unit
        Quantity and unit of the values, as on the axis.
    curves
        The first is drawn over all others.
    """

    title: str
    frequency: Array
    unit: str
    curves: Sequence[PageCurve]

    @property
    def json(self) -> str:
        """Return the chart as the script in the page reads it."""
        drawn = [
            {
                "label": curve.label,
                "colour": curve.colour,
                "dashed": curve.dashed,
                "width": curve.width,
                "values": _rounded(curve.values),
                "band": None
                if curve.log_error is None
                else [
                    _rounded(curve.values * np.exp(sign * curve.log_error)) for sign in (1.0, -1.0)
                ],
            }
            for curve in self.curves
        ]
        values = {"unit": self.unit, "x": _rounded(self.frequency, 6), "curves": drawn}
        # "</" would end the script element that holds it
        return json.dumps(values, separators=(",", ":"), ensure_ascii=False).replace("</", "<\\/")


def _rounded(values: Array, digits: int = DIGITS) -> list[float | None]:
    """Return values to some significant digits for a logarithmic axis; None for a gap."""
    return [
        float(f"{value:.{digits}g}") if np.isfinite(value) and value > 0 else None
        for value in values.tolist()
    ]


@dataclass(frozen=True)
class Picture:
    """An image with its caption.

    Attributes
    ----------
    name
        Anchor in the page and stem of the picture's file.
    image
        The image as a file.
    caption
        Caption, and the text of the image for who cannot see it.
    charts
        The same curves for a reader to zoom and to switch; the image then stands for them where
        there are no scripts, and in print.
    format
        Format of the image.
    """

    name: str
    image: bytes
    caption: str
    charts: Sequence[Chart] = ()
    format: Literal["png", "webp"] = "png"
    kind: Literal["picture"] = "picture"

    @property
    def base64(self) -> str:
        """Return the image as text for a ``data:`` address."""
        return base64.b64encode(self.image).decode("ascii")

    @property
    def is_broad(self) -> bool:
        """Whether the picture takes the width of the page."""
        return (self.width or 0) > BROAD

    @property
    def width(self) -> int | None:
        """Return the width at which a PNG of `RESOLUTION` is shown [pixel]; None for no PNG."""
        if not self.image.startswith(b"\x89PNG") or len(self.image) < 24:
            return None
        return round(int.from_bytes(self.image[16:20], "big") * SHOWN_PER_INCH / RESOLUTION)


@dataclass(frozen=True)
class Table:
    """Rows of text.

    Attributes
    ----------
    caption
        Caption.
    columns
        Heads of the columns, with units.
    rows
        Rows, each as long as ``columns``.
    folded
        Whether the rows are hidden behind the title.
    cards
        Whether each row is a block of its own on a narrow screen.
    title
        What folded rows are hidden behind; none for the caption.

    Raises
    ------
    ValueError
        For a row of another length.
    """

    caption: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    folded: bool = False
    cards: bool = False
    title: str = ""
    kind: Literal["table"] = "table"

    @property
    def is_narrow(self) -> bool:
        """Whether the rows are so short and so many that they stand in columns."""
        return len(self.columns) <= 5 and len(self.rows) > 30

    @property
    def parts(self) -> list[Sequence[Sequence[str]]]:
        """The rows of each of the columns in which they stand."""
        height = -(-len(self.rows) // 3) if self.is_narrow else max(1, len(self.rows))
        return [self.rows[start : start + height] for start in range(0, len(self.rows), height)]

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(
                    f"table '{self.caption}': a row of {len(row)} cells for "
                    f"{len(self.columns)} columns: {list(row)}"
                )


@dataclass(frozen=True)
class Fold:
    """Blocks behind their title.

    Attributes
    ----------
    title
        What is behind it.
    blocks
        What opens, in order.
    """

    title: str
    blocks: Sequence[Paragraph | Picture | Table]
    kind: Literal["fold"] = "fold"


Block = Paragraph | Picture | Table | Fold


@dataclass(frozen=True)
class PageSection:
    """A heading and the blocks below it.

    Attributes
    ----------
    name
        Anchor in the page.
    title
        Heading.
    blocks
        What is below it, in order.
    folded
        Whether the blocks are hidden behind the heading.
    """

    name: str
    title: str
    blocks: Sequence[Block]
    folded: bool = False

    @property
    def pictures(self) -> list[Picture]:
        """Return all pictures in order."""
        return [block for block in unfolded(self.blocks) if isinstance(block, Picture)]

    def with_suffix(self, suffix: str) -> PageSection:
        """Return the section as one of several, each of something else.

        Examples
        --------
        >>> Section("coupon", "Coupon", []).with_suffix("steel")
        Section(name='coupon-steel', title='Coupon: steel', blocks=[], folded=False)
        """
        blocks = [_with_suffix(block, suffix) for block in self.blocks]
        return PageSection(f"{self.name}-{suffix}", f"{self.title}: {suffix}", blocks, self.folded)


def _with_suffix(block: Any, suffix: str) -> Any:
    if isinstance(block, Fold):
        return replace(block, blocks=[_with_suffix(inner, suffix) for inner in block.blocks])
    return replace(block, name=f"{block.name}_{suffix}") if isinstance(block, Picture) else block


def unfolded(blocks: Sequence[Block]) -> Iterator[Paragraph | Picture | Table]:
    """Yield blocks with those behind folds in their places."""
    for block in blocks:
        if isinstance(block, Fold):
            yield from block.blocks
        else:
            yield block


@dataclass(frozen=True)
class Page:
    """A whole page.

    Attributes
    ----------
    title
        Heading.
    answer
        The result in a sentence or two, with its errors.
    first
        What is shown below it: the table, the drawing, the curves that decide.
    caveats
        What a reader must know before he uses the answer, a line each.
    facts
        What was computed and with what, as (name, value).
    assumptions
        What the study assumes where the source states nothing.
    summary
        Further results in sentences.
    warnings
        Limitations of the numbers in sentences.
    claims
        Table of claims with their verdicts; None where none is tested.
    sections
        In the order of the page.
    steps
        How to reproduce the results, as (text, command).
    """

    title: str
    facts: Sequence[tuple[str, str]]
    assumptions: Sequence[str]
    summary: Sequence[str]
    warnings: Sequence[str]
    claims: Table | None
    sections: Sequence[PageSection]
    steps: Sequence[tuple[str, str]] = field(default=())
    answer: str = ""
    first: Sequence[Block] = ()
    caveats: Sequence[str] = ()

    @property
    def pictures(self) -> list[Picture]:
        """Return all pictures in order."""
        first = [block for block in unfolded(self.first) if isinstance(block, Picture)]
        return first + [picture for section in self.sections for picture in section.pictures]

    @property
    def has_gap(self) -> bool:
        """Whether there is room beside the last of the first pictures, two of which make a row."""
        narrow = [b for b in unfolded(self.first) if isinstance(b, Picture) and not b.is_broad]
        return len(narrow) % 2 == 1

    @property
    def has_charts(self) -> bool:
        """Whether the page has curves that a reader can switch."""
        return any(picture.charts for picture in self.pictures)


def render(page: Page, folder: Path = TEMPLATE) -> str:
    """Return the page as one HTML text.

    Raises
    ------
    jinja2.UndefinedError
        For a variable of the template that `Page` does not have.
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
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        undefined=jinja2.StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    libraries = {path.name: path.read_text(encoding="utf-8") for path in LIBRARIES}
    return environment.get_template("report.html.j2").render(page=page, libraries=libraries)
