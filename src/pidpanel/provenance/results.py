"""Results files that are read again: one that is damaged is one line that names it."""

from collections.abc import Container, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import pandas as pd
import xarray as xr


class ResultsDamaged(ValueError):
    """A results file that cannot be read, or is not what its name says."""


REMEDY = "delete it and run the study again"


@contextmanager
def damage_named(path: Path) -> Iterator[None]:
    """Turn whatever a library raises on a damaged file into one line.

    Raises
    ------
    ResultsDamaged
        If the file is there and cannot be read. One that is not there is an `OSError`.
    """
    try:
        yield
    except (OSError, MemoryError):
        raise
    except Exception as error:  # of scipy's reader TypeError, ValueError, IndexError and others
        raise ResultsDamaged(f"{path}: cannot be read, as if damaged; {REMEDY}") from error


def read_csv(path: Path, columns: Sequence[str] = (), **options: Any) -> pd.DataFrame:
    """Read a table of results with some columns at least; ``options`` are of `pandas.read_csv`.

    Raises
    ------
    ResultsDamaged
    """
    with damage_named(path):
        table: pd.DataFrame = pd.read_csv(path, **options)
    _check(path, columns, table.columns)
    if columns and table.empty:
        raise ResultsDamaged(f"{path}: has no rows; {REMEDY}")
    return table


def read_netcdf(path: Path, variables: Sequence[str] = ()) -> xr.Dataset:
    """Read a NetCDF file of results whole, with some variables at least.

    Raises
    ------
    ResultsDamaged
    """
    with damage_named(path):
        dataset = xr.load_dataset(path, engine="scipy")
    _check(path, variables, dataset.variables)
    return dataset


def _check(path: Path, names: Sequence[str], content: Container[Any]) -> None:
    if missing := [name for name in names if name not in content]:
        raise ResultsDamaged(f"{path}: has no {', '.join(missing)}; {REMEDY}")
