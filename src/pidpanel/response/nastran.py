"""Nastran bulk data tables in large fields (16 characters)."""

from collections.abc import Iterator, Sequence

import numpy as np

from pidpanel.arrays import Array

FIELDS_PER_LINE = 4


def large_field_table(
    card: str, number: int, options: Sequence[str], x: Array, y: Array
) -> Iterator[str]:
    """Yield the lines of a table card such as TABRND1 or TABDMP1, each with its line end.

    Examples
    --------
    >>> print("".join(large_field_table("TABDMP1", 1, ["CRIT"], np.array([64.9]),
    ...                                 np.array([0.01]))).replace(" ", "."))
    TABDMP1*...............1............CRIT................................
    *
    *........6.490000000E+01.1.000000000E-02............ENDT
    <BLANKLINE>
    """
    fields = "".join(f"{option:>16}" for option in options)
    yield f"{card}*{number:16d}{fields:48}\n"
    yield "*\n"
    cells = [f"{value:16.9E}" for value in np.stack([x, y], axis=1).ravel()]
    cells.append(f"{'ENDT':>16}")
    for start in range(0, len(cells), FIELDS_PER_LINE):
        yield "*       " + "".join(cells[start : start + FIELDS_PER_LINE]) + "\n"
