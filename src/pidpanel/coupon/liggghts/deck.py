"""Decks of LIGGGHTS as text: templates rendered with values.

What the values are is said where the things are: `bed.Run.deck_values`.
"""

import os
import re
from collections.abc import Iterable, Mapping
from functools import cache, lru_cache
from pathlib import Path
from typing import Any

import jinja2
import jinja2.meta

from pidpanel.coupon.liggghts.failures import DeckRefused
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
        # a deck of the user's own may include ours; ours, from its real folder, only ours
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


def variables_in(template: Path) -> set[str]:
    """Return the variables of a template, and of the files beside it that it includes."""
    tree = jinja2.Environment().parse(template.read_text(encoding="utf-8"))
    names = set(jinja2.meta.find_undeclared_variables(tree))
    for name in jinja2.meta.find_referenced_templates(tree):
        path = template.with_name(name or template.name)
        if path.is_file() and path != template:
            names |= variables_in(path)
    return names


# Variable of the environment that is ``1`` where decks of one's own may do anything.
TRUST = "PIDPANEL_TRUST_DECK"


def comes_with_pidpanel(template: Path) -> bool:
    """Return whether a template is not of the user's own."""
    return template.resolve().is_relative_to(TEMPLATES.resolve())


def check_trust(template: Path) -> Path:
    """Refuse a template that did not come with pidpanel, unless such decks are trusted.

    A deck of the user's own is a program. A template can compute anything, and the commands of
    LIGGGHTS start programs and write files under many names. A list of what is harmless has to read
    a line exactly as LIGGGHTS does, and to know the files of every style; each gap is a program
    that starts. So nothing of such a deck is rendered or run before its user says that it may do
    anything (`TRUST`).

    Returns
    -------
    Path
        Path to read and render: that of a link to one of our templates is the template itself, so
        that it includes nothing that lies next to the link.

    Raises
    ------
    DeckRefused
        If the deck is not trusted, with its risks and how to allow it.
    """
    if comes_with_pidpanel(template):
        return template.resolve()
    if os.environ.get(TRUST) != "1":
        raise DeckRefused(
            f"{template}: your own deck is a program, which can start others and write any file; "
            "read it, then allow it with --trust-deck"
        )
    return template
