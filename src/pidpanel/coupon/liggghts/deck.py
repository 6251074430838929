"""Decks of LIGGGHTS as text: templates rendered with values.

For the values see `bed.Run.deck_values` and `drive.Tone.deck_values`.
"""

import re
from collections.abc import Iterable, Mapping
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import jinja2
import jinja2.meta

from pidpanel.paths import TEMPLATES
from pidpanel.provenance.digests import text_digest

START_FILE, WALLS_FILE = "start.data", "walls.stl"  # what a deck reads; see `start_files`


def cycles_file(leg: int) -> str:
    """Name of the file of cycle rows that a leg of a run writes."""
    return f"cycles_{leg}.txt"


def cells_file(leg: int) -> str:
    """Name of the file of rows by cell that a leg of a run writes."""
    return f"cells_{leg}.txt"


def lists_contacts(template: Path) -> bool:
    """Return whether a template can list the contacts of spheres with walls."""
    return "compute touches" in template.read_text(encoding="utf-8")


@cache
def digest(name: str, folder: Path, values: tuple[tuple[str, Any], ...]) -> str:
    """Return the hash of a deck without comments; equal values are rendered once per process."""
    return text_digest([without_comments(render(name, dict(values), folder))])


def _number(value: Any) -> Any:
    """Return numbers as LIGGGHTS reads them back exactly; text as it is."""
    if isinstance(value, float):
        return f"{value:.15g}"
    return value


@lru_cache
def _environment(folder: Path) -> jinja2.Environment:
    return jinja2.Environment(
        # a deck of the user's own may include ours
        loader=jinja2.FileSystemLoader([folder, TEMPLATES]),
        undefined=jinja2.StrictUndefined,
        keep_trailing_newline=True,
        trim_blocks=True,
        lstrip_blocks=True,
        finalize=_number,
        autoescape=False,
    )


def render(name: str, values: Mapping[str, Any], folder: Path = TEMPLATES) -> str:
    """Return the text of the deck ``templates/<name>`` with all its variables filled in.

    Raises
    ------
    jinja2.UndefinedError
        If a variable of the template is not in ``values``.
    """
    return _environment(folder).get_template(name).render(values)


_COMMENT = re.compile(r"""("[^"]*"|'[^']*')|#.*""")  # or what is quoted, which stays as it is
_BLANKS = re.compile(r"""("[^"]*"|'[^']*')|\s+""")


def without_comments(text: str) -> str:
    r"""Return a deck without comments, blank lines, indents and repeated spaces.

    Examples
    --------
    >>> without_comments("# pour\n\nrun  10 # steps\nprint 'a  # b'\n")
    "run 10\nprint 'a  # b'"
    """
    lines = (_COMMENT.sub(r"\1", line) for line in text.splitlines())
    lines = (_BLANKS.sub(lambda part: part[1] or " ", line).strip() for line in lines)
    return "\n".join(line for line in lines if line)


def undeclared(text: str, declared: Iterable[str]) -> list[str]:
    """Return the variables of a template that are not among the ``declared`` ones.

    Raises
    ------
    jinja2.TemplateSyntaxError
        If the template has a syntax error, with its line.
    """
    tree = jinja2.Environment().parse(text)
    return sorted(jinja2.meta.find_undeclared_variables(tree) - set(declared))
