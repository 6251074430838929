"""A page with its pictures as files."""

from __future__ import annotations

from pathlib import Path

from pidpanel.provenance import durable
from pidpanel.report.html import Page, render


def write_page(page: Page, file: Path, figures: Path) -> None:
    """Write a page, and each of its pictures as ``<name>.<format>`` into a folder."""
    figures.mkdir(exist_ok=True)
    for picture in page.pictures:
        (figures / f"{picture.name}.{picture.format}").write_bytes(picture.image)
    durable.write_text(file, render(page))
