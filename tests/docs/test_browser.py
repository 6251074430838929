"""The documents in headless Chromium, on a desk, on a telephone and on paper."""

import pytest
from browser import CHROMIUM, Browser, marks_by_page

if CHROMIUM is None:
    pytest.skip("Chromium is not installed, so no page is opened", allow_module_level=True)


WIDTHS = (1400, 390)


@pytest.fixture(scope="module")
def browser():
    with Browser(WIDTHS[0]) as opened:
        yield opened


def test_pages_open_without_complaint_network_or_overflow(browser, built):
    # .table-wrapper { overflow-x: visible } in pages.css
    pages = sorted(built[0].rglob("*.html"))
    assert len(pages) > 12
    width = "document.documentElement.scrollWidth - document.documentElement.clientWidth"
    for page in pages:
        browser.open(page, wait_ms=50)
        for pixels in WIDTHS:
            browser.resize(pixels)
            # the menus of a narrow screen wait beside it
            assert browser.overflowing("article") == [], (page.name, pixels)
            assert browser.run(width) <= 0, (page.name, pixels)
        assert browser.requests() == [], page.name
        assert browser.complaints() == [], page.name


def test_formulas_have_a_size(browser, built):
    browser.open(built[0] / "theory/index.html")
    sizes = browser.run(
        "[...document.querySelectorAll('math')].map(e => e.getBoundingClientRect().width)"
    )
    assert len(sizes) > 20
    assert min(sizes) > 5


PAPER = 700
"""Pixels between the margins of a sheet, about."""


FIXED = """[...document.querySelectorAll("body *")].filter(e => {
  const box = e.getBoundingClientRect();
  return getComputedStyle(e).position === "fixed" && box.width > 0 && box.height > 0
    && box.right > 0 && box.left < innerWidth;
}).map(e => e.className)"""
"""What stands over the text of every sheet."""


def test_pages_print_whole(built, tmp_path):
    with Browser(PAPER) as browser:
        browser.say("Emulation.setEmulatedMedia", media="print")
        for name in ("theory/coupon", "reference/study", "reference/messages", "tutorials/bead"):
            browser.open(built[0] / f"{name}.html")
            assert browser.overflowing("article") == [], name
            assert browser.run(FIXED) == [], name
            browser.pdf(tmp_path / "page.pdf")
            marks = marks_by_page(tmp_path / "page.pdf")
            assert len(marks) > 1
            assert min(marks) > 0
