"""The page as text: sections of paragraphs, pictures and tables into one self-contained file.

Images are in the page as base64 and the style is inline: the file needs no network and no other
file, and can be sent by mail.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Literal

import jinja2

from pidpanel.paths import TEMPLATES


@dataclass(frozen=True)
class Paragraph:
    """Plain text."""

    text: str
    kind: Literal["paragraph"] = "paragraph"


@dataclass(frozen=True)
class Picture:
    """An image with its caption.

    Attributes
    ----------
    name
        Anchor in the page and stem of the picture's file.
    png
        The image as PNG.
    caption
        Caption, and the text of the image for who cannot see it.
    """

    name: str
    png: bytes
    caption: str
    kind: Literal["picture"] = "picture"

    @property
    def base64(self) -> str:
        """Return the image as text for a ``data:`` address."""
        return base64.b64encode(self.png).decode("ascii")


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
        Whether the rows are hidden behind the caption.

    Raises
    ------
    ValueError
        For a row of another length.
    """

    caption: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    folded: bool = False
    kind: Literal["table"] = "table"

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(
                    f"table '{self.caption}': a row of {len(row)} cells for "
                    f"{len(self.columns)} columns: {list(row)}"
                )


Block = Paragraph | Picture | Table


@dataclass(frozen=True)
class Section:
    """A heading and the blocks below it.

    Attributes
    ----------
    name
        Anchor in the page.
    title
        Heading.
    blocks
        What is below it, in order.
    """

    name: str
    title: str
    blocks: Sequence[Block]

    def of(self, what: str) -> Section:
        """Return the section as one of several, each of something else.

        Examples
        --------
        >>> Section("coupon", "Coupon", []).of("steel")
        Section(name='coupon-steel', title='Coupon: steel', blocks=[])
        """
        blocks = [
            replace(block, name=f"{block.name}_{what}") if isinstance(block, Picture) else block
            for block in self.blocks
        ]
        return Section(f"{self.name}-{what}", f"{self.title}: {what}", blocks)


@dataclass(frozen=True)
class Page:
    """A whole page.

    Attributes
    ----------
    title
        Heading.
    facts
        What was computed and with what, as (name, value).
    assumptions
        What the study assumes where the source states nothing.
    summary
        Main results in sentences.
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
    sections: Sequence[Section]
    steps: Sequence[tuple[str, str]] = field(default=())

    @property
    def pictures(self) -> list[Picture]:
        """Return all pictures in order."""
        return [b for s in self.sections for b in s.blocks if isinstance(b, Picture)]


def render(page: Page, folder: Path = TEMPLATES / "report") -> str:
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
    return environment.get_template("report.html.j2").render(page=page)
