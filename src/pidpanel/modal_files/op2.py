"""Real eigenvectors, generalised masses and static displacements in OP2 of Nastran.

A file is a chain of Fortran records: a key of one word, then as many words if it is positive. A
negative key begins the next record of a table, 0 ends the table. Words have 4 or 8 bytes.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.modal_files.shapes import ModeShapes, bytes_of, stacked

TABLES = ("OUGV1", "OUG1", "OUGV1PAT", "OPHIG", "BOUGV1", "BOPHIG")  # the last two: basic frame
STATIC, NORMAL = 1, 2  # kinds of analysis
REAL = 1  # form of a number
ANALYSIS, TABLE, CASE, MODE, FORM, WIDTH = 0, 1, 3, 4, 8, 9  # words of an identification
EIGENVALUE, ROW, MASS = 5, 7, 5  # place there; words of a row of LAMA, place of its mass


class VectorBlock(NamedTuple):
    """Displacements of a mode or a static case."""

    words: Index  # of the identification
    eigenvalue: float
    node: Index
    vectors: Array


def read_op2(path: Path) -> ModeShapes:
    """Read real eigenvectors and static displacements, in the frames of their nodes."""
    masses: dict[int, float] = {}
    blocks: dict[str, list[VectorBlock]] = {}
    try:
        for name, records, real in _tables(bytes_of(path)):
            integer = np.dtype(f"{real.str[0]}i{real.itemsize}")
            if name == "LAMA":
                for record in records[4::2]:
                    rows = np.frombuffer(record, real).reshape(-1, ROW)
                    numbers = rows.view(integer)[:, 0].tolist()
                    masses |= zip(numbers, rows[:, MASS].tolist(), strict=True)
            elif name in TABLES:
                pairs = zip(records[3::2], records[4::2], strict=False)
                blocks.setdefault(name, []).extend(
                    _block(np.frombuffer(head, real), np.frombuffer(record, real), integer)
                    for head, record in pairs
                )
    except (ValueError, IndexError, OverflowError):
        raise ValueError(f"{path}: is no OP2 of Nastran, or is cut off") from None
    chosen = next((blocks[name] for name in TABLES if name in blocks), [])
    normal, static = (
        [b for b in chosen if b.words[ANALYSIS] // 10 == analysis and b.words[FORM] <= REAL]
        for analysis in (NORMAL, STATIC)
    )
    if chosen and not normal + static:
        raise ValueError(f"{path}: has no real eigenvectors, only complex ones or another analysis")
    if len(cases := {int(block.words[CASE]) for block in normal}) > 1:
        raise ValueError(f"{path}: has modes of subcases {sorted(cases)}; one is allowed")
    node = (normal + static)[0].node if normal or static else np.empty(0, dtype=np.int64)
    if not all(np.array_equal(node, block.node) for block in normal + static):
        raise ValueError(f"{path}: its modes or static cases have different nodes")
    value = np.array([block.eigenvalue for block in normal])
    frequency = np.sign(value) * np.sqrt(np.abs(value)) / (2 * np.pi)
    mass = [masses.get(int(block.words[MODE]), 0.0) for block in normal]
    vectors = [block.vectors for block in normal]
    modes = list(zip(frequency.tolist(), mass, vectors, strict=True))
    return stacked(node, modes, [block.vectors for block in static])


def _block(head: Array, values: Array, integer: np.dtype[np.int64]) -> VectorBlock:
    """Return the displacements of the points of a record."""
    words = head.view(integer)
    rows = values.reshape(-1, int(words[WIDTH]))
    numbers = rows.view(integer)[:, 0] // 10
    return VectorBlock(words, float(head[EIGENVALUE]), numbers, rows[:, 2:5].astype(float))


def _tables(data: bytes) -> Iterator[tuple[str, list[bytes], np.dtype[np.float64]]]:
    """Yield name and records of each table, and the type of its real words."""
    order = "<" if data[:1] in (b"\4", b"\x08") else ">"
    size = int.from_bytes(data[:4], "little" if order == "<" else "big")
    if size not in (4, 8):
        raise ValueError("no key at the beginning")
    integer, real = np.dtype(f"{order}i{size}"), np.dtype(f"{order}f{size}")
    chain = _chain(data, np.dtype(f"{order}i4"))
    records: list[list[bytes]] = [[]]
    for key in chain:
        count = int(np.frombuffer(key, integer)[0])
        if count > 0:
            records[-1].append(next(chain, b""))
        elif count < 0:
            records.append([])
        else:
            name = b"".join(records[0])[: 2 * size].replace(b" ", b"").decode("latin-1")
            flagged = [parts if k < 2 else parts[1:] for k, parts in enumerate(records)]
            yield name, [b"".join(parts) for parts in flagged], real
            records = [[]]


def _chain(data: bytes, marker: np.dtype[np.int32]) -> Iterator[bytes]:
    """Yield the contents of Fortran records between their lengths."""
    start = 0
    while start < len(data):
        length = int(np.frombuffer(data[start : start + 4], marker)[0])
        end = start + 4 + length
        if length < 0 or data[end : end + 4] != data[start : start + 4]:
            raise ValueError("lengths around a record differ")
        yield data[start + 4 : end]
        start = end + 4
