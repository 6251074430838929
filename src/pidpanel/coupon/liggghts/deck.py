"""What LIGGGHTS reads, as text: decks from the templates, data files."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from functools import lru_cache
from pathlib import Path
from typing import Any

import jinja2
import jinja2.meta

from pidpanel.arrays import Array
from pidpanel.paths import TEMPLATES


def _number(value: Any) -> Any:
    """Numbers as LIGGGHTS reads them back exactly; text as it is."""
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
    """Text of the deck ``templates/<name>`` with all its variables filled in.

    Raises
    ------
    jinja2.UndefinedError
        For a variable that the template names and ``values`` does not hold.
    """
    return _environment(folder).get_template(name).render(values)


def template_text(names: tuple[str, ...], folder: Path = TEMPLATES) -> str:
    """Source of the templates, joined: part of what a case's label is made from."""
    return "".join((folder / name).read_text(encoding="utf-8") for name in names)


def undeclared(text: str, known: Iterable[str]) -> list[str]:
    """Variables that a template asks for and that are not among the ``known`` ones.

    Raises
    ------
    jinja2.TemplateSyntaxError
        With the line.
    """
    tree = jinja2.Environment().parse(text)
    return sorted(jinja2.meta.find_undeclared_variables(tree) - set(known))


def data_file(
    positions: Array,
    diameters: Array,
    density: float,
    box: Array,
) -> str:
    """LIGGGHTS data file of spheres.

    Parameters
    ----------
    positions, diameters
        (n, 3) centres and (n,), m.
    density
        kg/m³.
    box
        (3, 2) lower and upper bounds of the simulation box, m.
    """
    bounds = "".join(
        f"{low:.9g} {high:.9g} {axis}lo {axis}hi\n"
        for (low, high), axis in zip(box, "xyz", strict=True)
    )
    atoms = "".join(
        f"{i} 1 {d:.9g} {density:.9g} {x:.12g} {y:.12g} {z:.12g}\n"
        for i, ((x, y, z), d) in enumerate(zip(positions, diameters, strict=True), 1)
    )
    return f"spheres\n\n{len(positions)} atoms\n2 atom types\n\n{bounds}\nAtoms\n\n{atoms}"
