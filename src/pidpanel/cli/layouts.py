"""The study of the best layouts that a search proposes."""

from pathlib import Path
from typing import Any

import pandas as pd

from pidpanel.provenance import durable
from pidpanel.provenance.results import read_csv
from pidpanel.study import StudyError
from pidpanel.study.document import Document
from pidpanel.study.writing import text_of

WRITTEN = 3  # layouts of the study that is written


def check_target(file: Path, study: Path, *, force: bool) -> None:
    """Refuse a file that exists, or from whose folder the files of the study are not found."""
    if file.suffix not in (".yaml", ".yml"):
        raise StudyError(f"{file}: must end in .yaml")
    if file.exists() and (not force or file.samefile(study)):
        raise StudyError(f"{file}: exists; --force overwrites it")
    if file.absolute().parent != study.absolute().parent:
        raise StudyError(
            f"{file}: must be in the folder of {study}: its tables are named relative to it"
        )


def write_study(study: Path, table: Path, file: Path) -> None:
    """Write a study whose scenarios are the first of the proposed layouts of a table."""
    values: dict[str, Any] = {**Document(study).data}
    values.pop("optimise")
    values.pop("name", None)
    patches, scenarios = dict(values["panel"].get("patches", {})), {}
    rows = read_csv(table, ["layout", "damper", "fill_fraction"], dtype={"damper": str})
    for layout in rows["layout"].unique()[:WRITTEN]:
        filled = {}
        for count, row in enumerate(rows[rows["layout"] == layout].to_dict("records"), start=1):
            name = f"layout {layout} patch {count}"
            patches[name] = {
                "centre_m": [row["centre_x_m"], row["centre_y_m"]],
                "size_m": [row["size_x_m"], row["size_y_m"]],
            }
            filled[name] = {"damper": row["damper"]}
            if pd.notna(row["fill_fraction"]):
                filled[name]["fill_fraction"] = row["fill_fraction"]
        scenarios[f"layout_{layout}"] = {"layout": filled}
    values["panel"] = {**values["panel"], "patches": patches}
    text = text_of({**values, "scenarios": scenarios})
    head = f"# The best layouts that pidpanel optimise {study.name} proposes.\n"
    durable.write_text(file, head + text)
