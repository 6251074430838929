"""The published table of cases, and the columns in ``datapackage.json``."""

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pandas as pd

FOLDER = Path(__file__).parent
PACKAGE_FILE = FOLDER / "datapackage.json"
TABLE_FILE = FOLDER / "cases.csv"
TYPES = {"number": float, "integer": int, "string": str, "boolean": bool}


def read_atlas(file: Path = TABLE_FILE) -> pd.DataFrame:
    """Read the table of cases.

    Returns
    -------
    DataFrame
        A row per case; columns and units as in ``datapackage.json``. Errors are standard errors.
        A case with one state of motion has no ``state_loss_factors``.
    """
    types = {str(field["name"]): TYPES[str(field["type"])] for field in fields()}
    blank = {name: [""] for name, kind in types.items() if kind is not str}
    return pd.read_csv(file, dtype=types, keep_default_na=False, na_values=blank)


def fields() -> list[Mapping[str, Any]]:
    """Return the columns of the table: name, type, unit, description, constraints."""
    (resource,) = json.loads(PACKAGE_FILE.read_text(encoding="utf-8"))["resources"]
    return list(resource["schema"]["fields"])
