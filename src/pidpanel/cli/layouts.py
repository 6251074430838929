"""The study of the best layouts that a search proposes."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.provenance import durable
from pidpanel.provenance.results import read_csv
from pidpanel.study import StudyError
from pidpanel.study.document import Document, load_study
from pidpanel.study.structure import KEY, Structure
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
    key = "panel" if "panel" in values else KEY
    patches, scenarios = dict(values[key].get("patches", {})), {}
    area_of = _area_on(study)
    rows = read_csv(
        table, ["layout", "damper", "fill_fraction"], dtype={"damper": str, "patch": str}
    )
    for layout in rows["layout"].unique()[:WRITTEN]:
        filled = {}
        for count, row in enumerate(rows[rows["layout"] == layout].to_dict("records"), start=1):
            name = row["patch"]
            if pd.isna(name):
                name = f"layout {layout} patch {count}"
                centre, size = (
                    [row[f"{kind}_{axis}_m"] for axis in "xy"] for kind in ("centre", "size")
                )
                patches[name] = area_of(centre, size)
            filled[name] = {"damper": row["damper"]}
            if pd.notna(row["fill_fraction"]):
                filled[name]["fill_fraction"] = row["fill_fraction"]
        scenarios[f"layout_{layout}"] = {"layout": filled}
    values[key] = {**values[key], "patches": patches}
    text = text_of({**values, "scenarios": scenarios})
    head = f"# The best layouts that pidpanel optimise {study.name} proposes.\n"
    durable.write_text(file, head + text)


def _area_on(study: Path) -> Callable[[list[float], list[float]], dict[str, Any]]:
    """Return centre and size of a rectangle [m] → a patch of the panel or the structure."""
    from pidpanel.structure.from_study import structure_of

    section = load_study(study).panel
    if not isinstance(section, Structure):
        return lambda centre, size: {"centre_m": centre, "size_m": size}
    origin, axes = structure_of(section).view

    def projected(centre: list[float], size: list[float]) -> dict[str, Any]:
        corners = np.add(centre, np.multiply([[-1, -1], [1, -1], [1, 1], [-1, 1]], size) / 2)
        in_space = (origin + corners @ axes.T).round(9) + 0.0
        return {"corners_m": in_space.tolist(), "along": np.cross(*axes.T).round(9).tolist()}

    return projected
