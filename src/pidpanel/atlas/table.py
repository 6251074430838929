"""The published table of cases, and the columns in ``datapackage.json``."""

import json
from collections.abc import Iterator, Mapping
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

    Raises
    ------
    ValueError
        If values are not allowed by ``datapackage.json``, with a line for each.
    """
    texts = pd.read_csv(file, dtype=str, keep_default_na=False)
    if faults := list(faults_of(texts, fields())):
        raise ValueError("\n".join(f"{file}: {fault}" for fault in faults))
    types = {str(field["name"]): TYPES[str(field["type"])] for field in fields()}
    blank = {name: [""] for name, kind in types.items() if kind is not str}
    return pd.read_csv(file, dtype=types, keep_default_na=False, na_values=blank)


def fields(file: Path = PACKAGE_FILE) -> list[Mapping[str, Any]]:
    """Return the columns of the table: name, type, unit, description, constraints."""
    (resource,) = json.loads(file.read_text(encoding="utf-8"))["resources"]
    return list(resource["schema"]["fields"])


def faults_of(texts: pd.DataFrame, columns: list[Mapping[str, Any]]) -> Iterator[str]:
    """Yield what of a table of texts its columns do not allow."""
    names = [str(column["name"]) for column in columns]
    if list(texts.columns) != names:
        wrong = sorted(set(names) ^ set(texts.columns)) or names
        yield f"columns must be those of datapackage.json; different are {', '.join(wrong)}"
        return
    for column in columns:
        values = texts[str(column["name"])]
        for index, value in enumerate(values.tolist()):
            if message := _refusal(value, str(column["type"]), column.get("constraints", {})):
                yield f"row {index}: {column['name']} = {value!r}: {message}"
        if column.get("constraints", {}).get("unique") and values.duplicated().any():
            yield f"{column['name']}: duplicate value {values[values.duplicated()].iloc[0]!r}"


def _refusal(text: str, kind: str, constraints: Mapping[str, Any]) -> str:
    if not text:
        return "must have a value" if constraints.get("required") else ""
    if "enum" in constraints and text not in map(str, constraints["enum"]):
        return f"must be one of {', '.join(map(str, constraints['enum']))}"
    if kind not in ("number", "integer"):
        return ""
    try:
        value = int(text) if kind == "integer" else float(text)
    except ValueError:
        return f"must be {'a whole number' if kind == 'integer' else 'a number'}"
    low, high = (constraints.get(key) for key in ("minimum", "maximum"))
    if (low is not None and value < low) or (high is not None and value > high):
        return f"must be from {low} to {high}"
    return ""
