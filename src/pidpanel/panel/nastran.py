"""Plane meshes from Nastran bulk data: GRID, CTRIA3, CTRIAR, CQUAD4 and CQUADR.

A deck with any other card (supports, masses, other elements, includes) describes another panel than
would be read, so it is refused with the card and its line, unless the study lists the card as
ignored. Cards that place nodes or elements cannot be ignored. Properties and materials are ignored:
the section comes from the study. So are coordinate systems that no node is placed in, parameters,
and the executive and case control before ``BEGIN BULK``. Whatever is not used is counted. Fields
may be short (8), long (16, ``GRID*``) or free (commas).
"""

import math
import re
from collections import Counter
from collections.abc import Collection, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np

from pidpanel.constants import PLACING_CARDS
from pidpanel.panel.flat_mesh import FlatMesh, MeshFileError, read_mesh_file
from pidpanel.text_files import lines_of

CORNERS = {"CTRIA3": 3, "CTRIAR": 3, "CQUAD4": 4, "CQUADR": 4}
READ = ("GRID", "GRDSET", *CORNERS)
# Cards replaced by the section of the study, and cards of an analysis
IGNORED = ("PSHELL", "PCOMP", "PCOMPG", "MAT1", "MAT2", "MAT8", "PARAM", "EIGRL", "EIGR")
SYSTEMS = tuple(f"CORD{number}{kind}" for number in "12" for kind in "RCS")
BULK = ["BEGIN", "BULK"]
ALLOWED = ", ".join(("GRID", *CORNERS, *IGNORED, "BEGIN BULK", "ENDDATA"))
ADVICE = "state supports and masses in the study and list their cards in panel.mesh.ignore"
PLACED = "it places nodes or elements, so it cannot be ignored"
# Place of the mass among the fields of a card
MASS_FIELD = {"CONM1": 3, "CONM2": 3, "CMASS2": 1, "CMASS4": 1}
# More than any card that is read has; lists of nodes have more
MOST_FIELDS, MOST_LISTED = 64, 1_000_000
# A file with more mistakes is not read to its end
COUNTED_FAULTS = 1000
# Nastran may leave out the E of an exponent: 1.5-3 is 0.0015
SHORT_EXPONENT = re.compile(r"(?<=[0-9.])([+-][0-9]+)$")


@dataclass
class _Deck:
    """The nodes and elements of a deck, and what of it is not used."""

    node: list[int] = field(default_factory=list)
    position: list[list[float]] = field(default_factory=list)
    element: list[int] = field(default_factory=list)
    corners: list[list[int]] = field(default_factory=list)
    groups: dict[str, list[int]] = field(default_factory=dict)
    unused: Counter[str] = field(default_factory=Counter)
    mass: dict[str, float] = field(default_factory=dict)

    def read(self, name: str, fields: list[str]) -> None:
        """Read a card; raise `ValueError` for what cannot be read."""
        if name == "GRDSET":
            self._read_node_options(name, [fields[1], "", "", "", *fields[5:]])
        elif name == "GRID":
            self._read_node_options(name, fields[1:])
            number = _integer(fields[0])
            self.position.append([real_number(value or "0") for value in fields[2:5]])
            self.node.append(number)
        else:
            count = CORNERS[name]
            number, nodes = _integer(fields[0]), [_integer(text) for text in fields[2 : 2 + count]]
            if any(text and real_number(text) != 0 for text in fields[2 + count :]):
                self.unused[f"{name} with angle, offset or thickness"] += 1
            self.groups.setdefault(fields[1] or fields[0], []).append(len(self.element))
            self.element.append(number)
            self.corners.append(nodes)

    def _read_node_options(self, name: str, fields: list[str]) -> None:
        system, _, _, _, out_system, constraints, *trailing = fields
        if system not in ("", "0"):
            raise ValueError(f"CP = {system} is not read; allowed is blank, the basic system")
        for text, label in ((out_system, "CD"), (constraints, "PS")):
            if not re.fullmatch("-?[0-9]*", text):
                raise ValueError(f"{label} = {text} is not a number")
            if text not in ("", "0"):
                self.unused[f"{name} with {label} = {text}"] += 1
        if any(text not in ("", "0") for text in trailing):
            raise ValueError(f"a field after PS is not read: {' '.join(trailing).strip()}")

    def skip(self, name: str, fields: list[str]) -> None:
        """Count a card that is not used, and its mass."""
        if name in IGNORED or name in SYSTEMS:
            return
        self.unused[name] += 1
        if name in MASS_FIELD:
            mass = real_number(fields[MASS_FIELD[name]] or "0")
            self.mass[name] = self.mass.get(name, 0.0) + mass

    def remarks(self) -> list[str]:
        """Return what is not used, with its mass in the unit of the deck."""
        mass = {
            name: f" (mass {value:g} in the unit of the deck)" for name, value in self.mass.items()
        }
        return [f"{count} {name}{mass.get(name, '')}" for name, count in self.unused.items()]


def read_nastran(path: Path, ignored: Collection[str] = (), unit: float = 1.0) -> FlatMesh:
    """Read a plane mesh from bulk data; groups are the property numbers of the elements.

    Parameters
    ----------
    ignored
        Further cards to ignore, such as SPC1 and CONM2; they are counted.
    unit
        Length unit of the file [m].

    Raises
    ------
    MeshFileError
        A line for each mistake: file, line, card, what is allowed.
    ValueError
        If `FlatMesh.from_elements` refuses the elements.
    """
    deck = _Deck()
    faults: list[str] = []
    told: set[str] = set()
    for line, name, fields in read_cards(path, faults):
        try:
            if name in READ:
                deck.read(name, fields + 16 * [""])
            elif name in {*IGNORED, *SYSTEMS, *ignored} and not PLACING_CARDS.match(name):
                deck.skip(name, fields + 16 * [""])
            elif name not in told:  # reported once
                told.add(name)
                advice = PLACED if PLACING_CARDS.match(name) else ADVICE
                faults.append(
                    f"{path}:{line}: card {name} is not read; allowed are {ALLOWED}; {advice}"
                )
        except ValueError as error:
            faults.append(f"{path}:{line}: {name}: {error}")
        if len(faults) > COUNTED_FAULTS:
            break
    if faults:
        raise MeshFileError(faults)
    if not deck.element:
        raise ValueError(f"{path}: no CTRIA3 or CQUAD4; a mesh needs one")
    return FlatMesh.from_elements(
        path,
        deck.node,
        unit * np.array(deck.position).reshape(-1, 3),
        deck.element,
        deck.corners,
        deck.groups,
        deck.remarks(),
    )


def read_cards(
    path: Path, faults: list[str], lists: Collection[str] = ()
) -> Iterator[tuple[int, str, list[str]]]:
    """Yield line number, name and fields of each card; add the faults of other lines.

    ``lists`` are further cards of which all fields are needed.
    """
    pending: tuple[int, str, list[str]] | None = None
    data = read_mesh_file(path)
    if b"\0" in data:
        line = data[: data.index(b"\0")].count(b"\n") + 1
        raise ValueError(f"{path}:{line}: must be text; it has a byte 0x00, as of a binary file")
    # comments may be in any encoding
    lines = [raw.split("$")[0].rstrip().expandtabs(8) for raw in lines_of(data.decode("latin-1"))]
    if next(filter(None, lines), "").startswith("*"):
        raise ValueError(f"{path}: must be Nastran bulk data; it begins like an input of Abaqus")
    control = next((k for k, text in enumerate(lines) if text.upper().split() == BULK), 0)
    for number, text in enumerate(lines, 1):
        words = text.upper().split()
        if not words or (number <= control and words[0] != "INCLUDE"):
            continue
        if words[0] == "ENDDATA" or words == ["END", "BULK"]:
            break
        if words == BULK:
            continue
        head, fields, surplus = _fields(text)
        name = head.rstrip("*").strip().upper()
        is_continuation = name in ("", "+") or head.startswith(("+", "*"))
        card = pending[1] if pending is not None and is_continuation else name
        if surplus and (card in READ or card in lists):
            message = f"{card}: '{surplus}' follows the eighth field of a line"
            faults.append(f"{path}:{number}: {message}; allowed is a mark of continuation")
        if is_continuation:
            if pending is None:
                faults.append(f"{path}:{number}: a continuation without a card")
            elif len(pending[2]) <= (MOST_LISTED if card in lists else MOST_FIELDS):
                pending[2].extend(fields)
            elif pending[1] in READ:
                faults.append(f"{path}:{number}: a card has more than {MOST_FIELDS} fields")
                break
            continue
        if pending is not None:
            yield pending
        placing = re.match("BEGIN|INCLUDE|=", words[0])
        pending = number, placing[0] if placing else name, fields
    if pending is not None:
        yield pending


def _fields(text: str) -> tuple[str, list[str], str]:
    """Return the name of a card, its fields, and what follows them but for a continuation mark."""
    if "," in text:
        # fields 2 to 9; the tenth marks a continuation
        head, *fields = (field.strip() for field in text.split(","))
        width = 4 if "*" in head else 8
        if re.fullmatch(r"[+*]([A-Za-z]\w*)?", fields[-1]):
            fields.pop()  # a mark of continuation wherever the line ends
        fields += [""] * (width - len(fields))  # what continues begins in the ninth field
        mark, *surplus = [*fields[width:], ""]
        if not re.fullmatch(r"([+*A-Za-z].*)?", mark):
            surplus = [mark, *surplus]
        return head, fields[:width], ", ".join(filter(None, surplus))
    head, body = text[:8].strip(), text[8:72]
    width = 16 if "*" in head else 8
    return head, [body[k : k + width].strip() for k in range(0, 64, width)], ""


def _integer(text: str) -> int:
    number = int(text) if re.fullmatch("[0-9]{1,18}", text) else 0
    if number < 1:
        raise ValueError(f"{text or 'a blank'} is not allowed; a number from 1 is needed")
    return number


def real_number(text: str) -> float:
    """Return a number as Nastran writes it; `ValueError` for what is none."""
    try:
        number = float(SHORT_EXPONENT.sub(r"e\1", text.upper().replace("D", "E")))
    except ValueError:
        number = math.nan
    if not math.isfinite(number):
        raise ValueError(f"{text} is not a number")
    return number
