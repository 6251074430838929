"""Pages in headless Chromium, on a desk, on a telephone and on paper."""

import pytest
from browser import CHROMIUM, Browser, marks_by_page

if CHROMIUM is None:
    pytest.skip("Chromium is not installed, so no page is opened", allow_module_level=True)

WIDTHS = (1400, 390)
MOST_BYTES = 15e6


@pytest.fixture(scope="module", params=WIDTHS)
def browser(request):
    with Browser(request.param) as opened:
        yield opened


@pytest.fixture(params=["table", "coupon"])
def page(request):
    """The page of a study with a panel, and that of a coupon alone."""
    return request.getfixturevalue(request.param)[1] / "report.html"


def test_a_page_opens_without_complaint_network_or_overflow(browser, page):
    browser.open(page)
    assert browser.overflowing() == []
    browser.unfold()
    assert browser.overflowing() == []
    assert browser.complaints() == []
    assert browser.requests() == []
    assert page.stat().st_size < MOST_BYTES


def test_everything_but_the_answer_is_folded(browser, table):
    browser.open(table[1] / "report.html")
    shown = browser.run(
        "[...document.querySelectorAll('h2, figure')].filter(e => e.checkVisibility())"
        ".map(e => e.id)"
    )
    figures = browser.run("[...document.querySelectorAll('.first figure')].map(e => e.id)")
    assert figures == ["panel", "answer", "reduction_mass"]
    headings = browser.run("[...document.querySelectorAll('h2')].map(e => e.id)")
    assert set(shown) == {*figures, *headings}
    browser.run("location.hash = '#maps'; new Promise(done => setTimeout(done, 300))")
    assert browser.run("document.getElementById('maps').closest('details').open")
    assert not browser.run("document.getElementById('sound').closest('details').open")


def test_curves_are_drawn_and_can_be_read_zoomed_and_switched(browser, table):
    browser.open(table[1] / "report.html")
    there = "document.querySelector('#answer div.chart')"
    width = browser.run(f"{there}.querySelector('canvas').getBoundingClientRect().width")
    assert width > 250
    # the curve of the bare panel leaves black pixels
    dark = f"""(() => {{
      const c = {there}.querySelector('canvas');
      const d = c.getContext('2d').getImageData(60, 0, c.width - 60, c.height - 60).data;
      let n = 0;
      for (let i = 0; i < d.length; i += 4) n += d[i + 3] > 60 && d[i] + d[i + 1] + d[i + 2] < 60;
      return n;
    }})()"""
    with_bare = browser.run(dark)
    bare = f"{there}.querySelector('.u-legend tr.first th')"
    browser.run(f"{bare}.click(); new Promise(done => setTimeout(done, 200))")
    without = browser.run(dark)
    assert with_bare > 2 * without + 100
    browser.run(f"{bare}.click(); new Promise(done => setTimeout(done, 200))")
    assert browser.run(dark) == pytest.approx(with_bare, rel=0.02)
    names = browser.run(f"{there}.getAttribute('aria-label')")
    assert "Acceleration PSD at point" in names
    press_keys(browser, there)
    # by hand: the pointer over the middle of the curves, then a drag over a part of them
    browser.run(f"{there}.scrollIntoView({{block: 'center'}})")
    box = browser.run(
        f"(() => {{ const b = {there}.querySelector('.u-over').getBoundingClientRect();"
        " return [b.left, b.top, b.width, b.height]; })()"
    )
    x, y = box[0] + box[2] / 2, box[1] + box[3] / 2
    value = f"{there}.querySelector('.u-legend tr .u-value').textContent"

    def mouse(kind, at, buttons=0):
        browser.say("Input.dispatchMouseEvent", type=kind, x=at, y=y, button="left" if buttons else "none",
                    buttons=buttons, clickCount=1 if buttons else 0)  # fmt: skip

    mouse("mouseMoved", x)
    browser.run("new Promise(done => setTimeout(done, 200))")
    middle = float(browser.run(value))
    mouse("mousePressed", x, 1)
    mouse("mouseMoved", x + 0.2 * box[2], 1)
    mouse("mouseReleased", x + 0.2 * box[2], 1)
    mouse("mouseMoved", box[0] + 2)
    browser.run("new Promise(done => setTimeout(done, 200))")
    # what was in the middle is now at the left
    assert float(browser.run(value)) == pytest.approx(middle, rel=0.05)


def press_keys(browser, there):
    """Switch a curve, read a value and zoom without a mouse."""

    def key(target, name):
        browser.run(
            f"{target}.dispatchEvent(new KeyboardEvent('keydown', {{key: '{name}', bubbles: true}}));"
            " new Promise(done => setTimeout(done, 100))"
        )

    name = f"{there}.querySelector('.u-legend tr.first th')"
    assert browser.run(f"[{there}.tabIndex, {name}.tabIndex, {name}.role]") == [0, 0, "button"]
    key(name, "Enter")
    assert browser.run(f"{name}.ariaPressed") == "false"
    key(name, " ")
    assert browser.run(f"{name}.ariaPressed") == "true"
    value = f"{there}.querySelector('.u-legend tr .u-value').textContent"
    key(there, "ArrowRight")
    first = float(browser.run(value))
    for _ in range(8):
        key(there, "ArrowRight")
    second = float(browser.run(value))
    assert second > first
    for _ in range(3):
        key(there, "+")
    for _ in range(8):
        key(there, "ArrowRight")
    # eight steps are a shorter way in a smaller range
    assert float(browser.run(value)) - second < second - first
    key(there, "0")


def test_a_printed_page_shows_its_sections_and_no_page_is_blank(tmp_path, page):
    with Browser(1400) as browser:
        browser.open(page)
        browser.pdf(tmp_path / "page.pdf")
        short = marks_by_page(tmp_path / "page.pdf")
        # with the tables and figures that the reader has opened
        browser.unfold()
        count = browser.run("document.querySelectorAll('tr').length")
        browser.pdf(tmp_path / "page.pdf")
        marks = marks_by_page(tmp_path / "page.pdf")
        # the curves are pictures on paper
        browser.say("Emulation.setEmulatedMedia", media="print")
        hidden = browser.run(
            "[...document.querySelectorAll('figure img')]"
            ".filter(e => getComputedStyle(e).display === 'none').length"
        )
    assert hidden == 0
    assert len(marks) > 1 and min(marks) > 5
    assert min(short) > 5 and sum(short) < sum(marks)
    # every cell of every table is a text of its own
    assert sum(marks) > count


def test_a_printed_page_is_no_wider_than_the_paper(page):
    with Browser(703) as browser:
        browser.open(page)
        browser.say("Emulation.setEmulatedMedia", media="print")
        browser.unfold()
        assert browser.overflowing() == []
