"""Plane meshes from Nastran bulk data: GRID, CTRIA3 and CQUAD4.

A deck with any other card (supports, loads, other elements, coordinate systems, includes)
describes another panel than would be read, so it is refused with the card and its line. PSHELL
and MAT1 are ignored: the section comes from the study. Fields may be
short (8), long (16, ``GRID*``) or free (commas).
"""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pidpanel.panel.flat_mesh import FlatMesh

CORNERS = {"CTRIA3": 3, "CQUAD4": 4}
IGNORED = ("PSHELL", "MAT1")
DELIMITERS = ("BEGIN BULK", "ENDDATA")
ALLOWED = ", ".join(("GRID", *CORNERS, *IGNORED, *DELIMITERS))
# Nastran may leave out the E of an exponent: 1.5-3 is 0.0015
SHORT_EXPONENT = re.compile(r"(?<=[0-9.])([+-][0-9]+)$")


def read_nastran(path: Path) -> FlatMesh:
    """Read a plane mesh from bulk data.

    Parameters
    ----------
    path
        A ``.bdf``, ``.dat`` or ``.nas`` file.

    Returns
    -------
    FlatMesh
        Groups are the property numbers of the elements.

    Raises
    ------
    ValueError
        One line: file, line, card, what is allowed.
    """
    node, position, element, corners, group = [], [], [], [], []
    for line, name, fields in _cards(path):
        where = f"{path}:{line}: {name}"
        if name == "GRID":
            number, system, x, y, z, out_system, held, *more = _padded(fields, 8)
            unread = [(system, "CP"), (out_system, "CD"), (held, "PS")]
            for field, what in unread + [(field, "a field after PS") for field in more]:
                if field not in ("", "0"):
                    raise ValueError(
                        f"{where}: {what} = {field} is not read; allowed is blank"
                        " (positions in the basic system, supports in the study)"
                    )
            node.append(_integer(where, number))
            position.append([_real(where, value or "0") for value in (x, y, z)])
        elif name in CORNERS:
            count = CORNERS[name]
            number, property_number, *rest = _padded(fields, 2 + count)
            element.append(_integer(where, number))
            group.append(property_number or number)
            corners.append([_integer(where, value) for value in rest[:count]])
            for value in rest[count:]:
                if value and _real(where, value) != 0:
                    raise ValueError(
                        f"{where}: field {value} after the nodes is not read; allowed is blank"
                        " (angles and offsets belong to the section)"
                    )
    if not element:
        raise ValueError(f"{path}: no CTRIA3 or CQUAD4; a mesh needs one")
    return FlatMesh.of(
        path, node, np.array(position).reshape(-1, 3), element, corners, np.array(group)
    )


def _cards(path: Path) -> Iterator[tuple[int, str, list[str]]]:
    """Yield line number, name and fields of each card that is read."""
    pending: tuple[int, str, list[str]] | None = None
    for number, raw in enumerate(path.read_text(encoding="latin-1").splitlines(), 1):
        text = raw.split("$")[0].rstrip().expandtabs(8)
        if not text.strip():
            continue
        if text.strip().upper() == "ENDDATA":
            break
        if text.strip().upper() == "BEGIN BULK":
            continue
        head, fields = _fields(text)
        name = head.rstrip("*").strip().upper()
        if name in ("", "+") or head.startswith(("+", "*")):
            if pending is None:
                raise ValueError(f"{path}:{number}: a continuation without a card")
            pending[2].extend(fields)
            continue
        if pending is not None and pending[1] not in IGNORED:
            yield pending
        if name not in ("GRID", *CORNERS, *IGNORED):
            raise ValueError(f"{path}:{number}: card {name} is not read; allowed are {ALLOWED}")
        pending = number, name, fields
    if pending is not None and pending[1] not in IGNORED:
        yield pending


def _fields(text: str) -> tuple[str, list[str]]:
    """Return the name of a card and its fields, without the continuation mark at the end."""
    if "," in text:
        # fields 2 to 9; the tenth marks a continuation
        head, *fields = (field.strip() for field in text.split(","))
        return head, fields[: 4 if "*" in head else 8]
    head, rest = text[:8].strip(), text[8:72]
    width = 16 if "*" in head else 8
    return head, [rest[k : k + width].strip() for k in range(0, 64, width)]


def _padded(fields: list[str], count: int) -> list[str]:
    """Return the fields with blanks up to a count."""
    return fields + [""] * (count - len(fields))


def _integer(where: str, text: str) -> int:
    try:
        number = int(text)
    except ValueError:
        number = 0
    if number < 1:
        raise ValueError(f"{where}: {text or 'a blank'} is not allowed; a number from 1 is needed")
    return number


def _real(where: str, text: str) -> float:
    try:
        return float(SHORT_EXPONENT.sub(r"e\1", text.upper().replace("D", "E")))
    except ValueError:
        raise ValueError(f"{where}: {text} is not a number") from None
