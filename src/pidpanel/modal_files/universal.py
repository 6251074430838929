"""Modes and meshes in universal files: data sets 55, 2414; 15, 2411, 2412, 2467; units of 164."""

import re
from collections.abc import Iterator
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.modal_files.shapes import ModeShapes, SurfaceElements, bytes_of, stacked
from pidpanel.tabular.units import unit_system

MARK = re.compile(rb"^ {4}-1[ \t]*\r?$", re.MULTILINE)
DOUBLE = bytes.maketrans(b"Dd", b"EE")  # exponents of Fortran
NODES = {15: 7, 781: 7, 2411: 7}  # values of a node
# Descriptors of linear and quadratic triangles and quadrilaterals: membranes, plates, shells
LINEAR = {decade + kind for decade in (40, 50, 60, 80, 90) for kind in (1, 4)}
QUADRATIC = {number + 1 for number in LINEAR}
BEAMS = {11, 21, 22, 23, 24}  # their elements have a line more
PROPERTY, ELEMENTS = 2, 8  # field of an element, code of an entity of groups
# Lines of identification, and places of the definition, of reals, and of the values, by data set
LAYOUT = {55: (5, 7, 8), 2414: (8, 11, 13)}
MASS_FIELD = {55: (0, 1), 2414: (1, 3)}  # frequency and modal mass among the reals
STATIC, NORMAL, COMPLEX = 1, 2, (3, 7)  # kinds of analysis
DISPLACEMENTS, VECTORS, COMPLEX_DATA = (0, 1, 8), (2, 3), (5, 6)
IN_PHASE = 1e-3  # largest imaginary part of normal modes that are written as complex


def data_sets(path: Path) -> Iterator[tuple[int, bytes]]:
    """Yield number and lines of each data set."""
    parts = MARK.split(bytes_of(path))
    for part in parts[1::2]:
        kind, _, lines = part.lstrip(b"\r\n").partition(b"\n")
        if kind.strip().isdigit():  # 58b is binary
            yield int(kind), lines


def read_mesh(path: Path) -> SurfaceElements:
    """Read the nodes, surface elements and groups of a universal file."""
    nodes: list[Array] = []
    element: list[int] = []
    corners: list[list[int]] = []
    groups: dict[str, list[int]] = {}
    named: dict[str, list[int]] = {}
    for kind, lines in data_sets(path):
        if kind in NODES:
            nodes.append(_numbers(path, kind, lines, NODES[kind]))
        elif kind == 2412:
            try:
                for fields, members in _elements(lines):
                    groups.setdefault(f"{fields[PROPERTY]}", []).append(len(element))
                    element.append(fields[0])
                    corners.append(members)
            except (ValueError, IndexError):
                message = f"an element after {element[-1:] or 'the beginning'}"
                raise ValueError(f"{path}: data set 2412: {message} cannot be read") from None
        elif kind in (2467, 2477):
            named.update(_groups(lines))
    place = {number: k for k, number in enumerate(element)}
    for name, numbers in named.items():
        groups[name] = [place[number] for number in numbers if number in place]
    table = np.concatenate(nodes) if nodes else np.empty((0, 7))
    if len(frames := np.unique(table[:, 1:3], axis=0)) > 1:
        names = ", ".join(f"{int(frame)}" for frame in np.unique(frames))
        raise ValueError(f"{path}: its nodes are in the frames {names}; one for all is allowed")
    return SurfaceElements(table[:, 0].astype(int), table[:, 4:], element, corners, groups)


def read_shapes(path: Path) -> ModeShapes:
    """Read the normal modes and static cases of a universal file."""
    modes: list[tuple[float, float, Array]] = []
    static: list[Array] = []
    largest: list[float] = []
    node: Index | None = None
    has_complex = False
    for kind, text in data_sets(path):
        if kind not in LAYOUT:
            continue
        identification, reals, header = LAYOUT[kind]
        lines = text.split(b"\n", header)
        if len(lines) <= header:
            raise ValueError(f"{path}: a data set {kind} is cut off")
        definition = _integers(lines[identification])
        _, analysis, characteristic, content, data, count = (*definition, *6 * [0])[:6]
        if content not in DISPLACEMENTS or characteristic not in VECTORS or count not in (3, 6):
            continue
        if kind == 2414 and _integers(lines[2]) != [1]:  # not at nodes
            continue
        if analysis in COMPLEX:
            has_complex = True
        elif analysis in (STATIC, NORMAL):
            parts = 2 if data in COMPLEX_DATA else 1
            table = _numbers(path, kind, lines[header], 1 + parts * count)
            numbers, vectors = table[:, 0].astype(int), table[:, 1::parts]
            size = float(np.abs(vectors).max(initial=0.0))
            if parts == 2 and np.abs(table[:, 2::2]).max(initial=0.0) > IN_PHASE * size:
                has_complex = True
                continue
            if node is None:
                node = numbers
            if not np.array_equal(node, numbers):
                place = f"{'mode' if analysis == NORMAL else 'static case'}"
                count = 1 + len(modes if analysis == NORMAL else static)
                raise ValueError(f"{path}: {place} {count} has other nodes than those before it")
            if analysis == STATIC:
                static.append(vectors[:, :3])
            else:
                values = _numbers(path, kind, lines[reals], 1)[:, 0]
                frequency, mass = (values[k] if k < len(values) else 0.0 for k in MASS_FIELD[kind])
                modes.append((frequency, mass, vectors[:, :3]))
                largest.append(size)
    if has_complex and not modes:
        raise ValueError(f"{path}: has complex modes alone; real normal modes are needed")
    node = np.empty(0, dtype=np.int64) if node is None else node
    return stacked(node, modes, static)._replace(largest=np.array(largest))


def read_units(path: Path) -> tuple[float, float] | None:
    """Return the units of length [m] and mass [kg] of data set 164; None without one."""
    for kind, lines in data_sets(path):
        if kind == 164:
            head, *values = lines.split(b"\n")
            code = _integers(head[:10])[0]
            length, force = _numbers(path, kind, b" ".join(values), 1)[:2, 0]
            length_unit, force_unit = unit_system(code, length, force)
            return float(length_unit.factor), float(force_unit.factor / length_unit.factor)
    return None


def _numbers(path: Path, kind: int, text: bytes, width: int) -> Array:
    """Return numbers between blanks in rows of a width; refuse others."""
    try:
        return np.array(text.translate(DOUBLE).split(), dtype=float).reshape(-1, width)
    except ValueError:
        message = f"data set {kind}: its values are not rows of {width} numbers"
        raise ValueError(f"{path}: {message}") from None


def _integers(line: bytes) -> list[int]:
    """Return the integers at the beginning of a line."""
    return [int(word) for word in line.split() if re.fullmatch(rb"-?\d+", word)]


def _elements(text: bytes) -> Iterator[tuple[list[int], list[int]]]:
    """Yield the first fields and the nodes of each surface element of data set 2412."""
    lines = iter(text.splitlines())
    for line in lines:
        fields = [int(word) for word in line.split()]
        if not fields:
            continue
        nodes: list[int] = []
        if fields[1] in BEAMS:
            next(lines)
        while len(nodes) < fields[5]:
            nodes += [int(word) for word in next(lines, b"").split()] or [int("")]
        if fields[1] in LINEAR:
            yield fields, nodes
        elif fields[1] in QUADRATIC:  # nodes go round
            yield fields, nodes[::2] + nodes[1::2]


def _groups(text: bytes) -> Iterator[tuple[str, list[int]]]:
    """Yield name and numbers of the elements of each group of data set 2467."""
    lines = iter(text.splitlines())
    for line in lines:
        fields = _integers(line)
        if len(fields) < 8:
            continue
        name = next(lines, b"").decode("latin-1").strip()
        entities: list[int] = []
        while len(entities) < 4 * fields[7] and (values := _integers(next(lines, b""))):
            entities += values
        pairs = zip(entities[::4], entities[1::4], strict=False)
        yield name, [number for code, number in pairs if code == ELEMENTS]
