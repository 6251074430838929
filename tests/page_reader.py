"""The parts of a page as a reader meets them: sections filled and read back from their HTML."""

from dataclasses import dataclass, field
from html.parser import HTMLParser
from unittest import mock

from pidpanel.report.html import Picture
from pidpanel.report.templates import environment


@dataclass
class Paragraph:
    text: str
    kind: str = "paragraph"


@dataclass
class Figure:
    name: str
    caption: str = ""
    kind: str = "picture"


@dataclass
class Table:
    caption: str = ""
    title: str = ""
    columns: list = field(default_factory=list)
    rows: list = field(default_factory=list)
    folded: bool = False
    kind: str = "table"


class _Reader(HTMLParser):
    def __init__(self):
        super().__init__()
        self.blocks, self.text, self.depth, self.title, self.caption = [], [], 0, "", ""
        self.is_help = False

    def handle_starttag(self, tag, attributes):
        about = dict(attributes)
        if tag in ("p", "figcaption", "summary", "th", "td", "script"):
            self.text = []
        if tag == "p":
            self.kind = about.get("class", "")
        elif tag == "figure":
            self.blocks.append(Figure(about.get("id", "")))
        elif tag == "details":
            self.depth += 1
        elif tag == "table" and "colours" not in about.get("class", ""):
            last = self.blocks[-1] if self.blocks else None
            self.continued = isinstance(last, Table) and not self.caption and not self.title
            if not self.continued:
                self.blocks.append(
                    Table(self.caption or self.title, self.title, folded=bool(self.depth))
                )
            self.caption = self.title = ""
        elif tag == "tr":
            self.cells, self.is_head = [], False
        elif tag == "span":  # how to use a chart
            self.is_help = True

    def handle_endtag(self, tag):
        text = " ".join("".join(self.text).split())
        last = self.blocks[-1] if self.blocks else None
        if tag == "span":
            self.is_help = False
        elif tag == "p" and self.kind == "caption":
            self.caption = text
        elif tag == "p" and self.kind != "over":
            self.blocks.append(Paragraph(text))
        elif tag == "summary":
            self.title = text
        elif tag == "details":
            self.depth -= 1
            self.title = ""
        elif tag == "figcaption":
            last.caption = text
        elif tag in ("th", "td"):
            self.cells.append(text)
            self.is_head |= tag == "th"
        elif tag == "tr" and isinstance(last, Table):
            if self.is_head:
                last.columns = self.cells
            else:
                last.rows.append(self.cells)

    def handle_data(self, data):
        if not self.is_help:
            self.text.append(data)


def blocks_of(section):
    """Paragraphs, tables and figures of a section or fragment in order, also those of folds."""
    reader = _Reader()
    show = environment().get_template("macros.html").module.show
    with mock.patch.object(Picture, "image", b""):  # none is drawn
        for block in getattr(section, "blocks", [section]):
            reader.feed(show(block))
    return reader.blocks
