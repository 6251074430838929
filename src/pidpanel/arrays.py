"""Types of the arrays that the whole package speaks of, and arrays with their units."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

if TYPE_CHECKING:
    import xarray as xr

Array = NDArray[np.float64]
Complexes = NDArray[np.complexfloating[Any, Any]]
Index = NDArray[np.int64]
Flags = NDArray[np.bool_]


def variable(dims: str, values: ArrayLike, units: str, long_name: str = "") -> xr.Variable:
    """Return values with their unit, for a dataset.

    Parameters
    ----------
    dims
        Names of the dimensions, with blanks between them.
    units
        Unit such as ``N s m-3``; ``1`` for numbers.

    Examples
    --------
    >>> variable("point", [0.2, 0.3], "m", "deflection").attrs
    {'units': 'm', 'long_name': 'deflection'}
    """
    import xarray as xr  # slow to import, and many commands need none

    attributes = {"units": units, "long_name": long_name} if long_name else {"units": units}
    return xr.Variable(dims.split(), values, attributes)


def described_variables(file: Path) -> dict[str, tuple[str, str, str]]:
    """Return dimensions, unit and long name of variables, from a table next to the code."""
    with file.open(encoding="utf-8", newline="") as stream:
        _, *rows = csv.reader(stream)
    return {name: (dims, unit, long_name) for name, dims, unit, long_name in rows}
