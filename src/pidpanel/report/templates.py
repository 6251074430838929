"""The templates of the pages, ``pages/*.html``, and the filters that write numbers in them."""

from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import Any

import jinja2
from markupsafe import Markup

from pidpanel.report import text

PAGES = Path(__file__).with_name("pages")

OF_TEXT = (
    "capitalised", "chance", "counted", "nominal", "number", "percent", "plain", "signed", "spaced",
    "unit", "value_text", "with_error",
)  # fmt: skip
FILTERS: Mapping[str, Callable[..., Any]] = {
    **{name: getattr(text, name) for name in OF_TEXT},
    "form": format,  # as `format(value, spec)`
}


@cache
def environment(folder: Path = PAGES) -> jinja2.Environment:
    """Return what renders the templates of a folder: names are escaped, none may be missing."""
    loaded = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folder),
        undefined=jinja2.StrictUndefined,
        autoescape=True,
        trim_blocks=True,
        lstrip_blocks=True,
        keep_trailing_newline=True,
    )
    loaded.filters.update(FILTERS)
    loaded.globals["fill"] = fill
    return loaded


def fill(name: str, values: Mapping[str, Any]) -> Markup:
    """Return a template of `PAGES` filled with values, as HTML.

    Raises
    ------
    jinja2.UndefinedError
        If the template needs a value that is missing.
    """
    return Markup(environment().get_template(name).render(values))


def sentence(name: str, values: Mapping[str, Any]) -> str:
    """Return a template filled with values as text in one line, without its tags."""
    return fill(name, values).striptags()


def lines(name: str, values: Mapping[str, Any]) -> list[str]:
    """Return the sentences of a template, each in ``<li>``, as text."""
    return [item.striptags() for item in fill(name, values).split("</li>")[:-1]]


def pairs(name: str, values: Mapping[str, Any]) -> list[tuple[str, str]]:
    """Return names and values, ``<dt>`` and ``<dd>`` of a template, as text."""
    items = [item.partition("</dt>") for item in fill(name, values).split("</dd>")[:-1]]
    return [(term.striptags(), text.striptags()) for term, _, text in items]
