"""The page as text: sections of paragraphs, pictures and tables into one self-contained file.

Images stand in the page as base64 and the style inline, so the file needs neither network
nor fellows and can be sent by mail.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass, field
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
    """An image with its caption; ``name`` is the stem of its file."""

    name: str
    png: bytes
    caption: str
    kind: Literal["picture"] = "picture"

    @property
    def base64(self) -> str:
        """The image as text for a ``data:`` address."""
        return base64.b64encode(self.png).decode("ascii")


@dataclass(frozen=True)
class Table:
    """Rows of text, as wide as ``columns``; ``folded`` hides them behind the caption."""

    caption: str
    columns: Sequence[str]
    rows: Sequence[Sequence[str]]
    folded: bool = False
    kind: Literal["table"] = "table"

    def __post_init__(self) -> None:
        for row in self.rows:
            if len(row) != len(self.columns):
                raise ValueError(
                    f"table '{self.caption}': a row of {len(row)} cells, "
                    f"{len(self.columns)} columns: {list(row)}"
                )


Block = Paragraph | Picture | Table


@dataclass(frozen=True)
class Section:
    """A heading and what stands under it; ``name`` is its anchor."""

    name: str
    title: str
    blocks: Sequence[Block]


@dataclass(frozen=True)
class Page:
    """The whole report.

    Attributes
    ----------
    title
        Heading.
    facts
        What was computed and with what, as (name, value).
    assumptions
        What the source leaves out and the study assumes.
    summary
        What came out, in sentences.
    warnings
        Where the numbers must not be trusted.
    claims
        Table of the claims with their verdicts; None where the study tests none.
    sections
        In the order of the page.
    steps
        How to come by these numbers again, as (text, command).
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
        """All pictures, in order."""
        return [b for s in self.sections for b in s.blocks if isinstance(b, Picture)]


def render(page: Page, folder: Path = TEMPLATES / "report") -> str:
    """Return the page as one HTML text.

    Raises
    ------
    jinja2.UndefinedError
        For a variable that the template names and `Page` does not hold.
    ValueError
        If two pictures or two sections carry one name.
    """
    for kind, names in (
        ("pictures", [picture.name for picture in page.pictures]),
        ("sections", [section.name for section in page.sections]),
    ):
        twice = sorted({name for name in names if names.count(name) > 1})
        if twice:
            raise ValueError(f"{kind} of one name: {', '.join(twice)}")
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        undefined=jinja2.StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    return environment.get_template("report.html.j2").render(page=page)
