"""A page with its pictures as files."""

from collections.abc import Sequence
from pathlib import Path

from pidpanel.provenance import durable
from pidpanel.report.html import Page, render
from pidpanel.report.style import Drawing


def write_page(page: Page, file: Path, figures: Path) -> None:
    """Write a page, and each of its images as ``<name>.<format>`` into a folder."""
    figures.mkdir(exist_ok=True)
    for picture in page.pictures:
        if picture.is_image:
            (figures / f"{picture.name}.{picture.format}").write_bytes(picture.image)
    durable.write_text(file, render(page))


def write_figures(page: Page, formats: Sequence[str], figures: Path) -> None:
    """Write the figures of a page as PNG, SVG or PDF into a folder; films are left out."""
    figures.mkdir(parents=True, exist_ok=True)
    for picture in page.pictures:
        if isinstance(picture.drawn, Drawing):
            for name in formats:
                picture.drawn.write(figures / f"{picture.name}.{name}")
