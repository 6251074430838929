"""Propose layouts of dampers within the mass budget of a study, and regenerate its report.

The section `optimise` of the study states the budget and the options. `--write` writes a study of
the best layouts. It computes their maps and stresses, and coupled runs of simulated particles.
"""

import argparse
import json
from pathlib import Path
from typing import Any

from pidpanel.cli import run

WRITTEN = 3  # layouts of the study that is written


def call(args: argparse.Namespace) -> int:
    from pidpanel.check import checked_study
    from pidpanel.study import Study, StudyError

    study = checked_study(args.study)
    if not isinstance(study, Study) or study.optimise is None:
        raise StudyError(f"{args.study}: optimise: missing; the section has the mass budget")
    if args.write is not None:
        check_target(args.write, args.study, force=args.force)
    status = run.call(args)
    if status == 0 and args.write is not None:
        table = args.directory / "results" / study.name / "optimise" / "layouts.csv"
        write_study(args.study, table, args.write)
        print(f"{args.write}: written; next: pidpanel check {args.write}")
    return status


def check_target(file: Path, study: Path, *, force: bool) -> None:
    """Refuse a file that exists, or from whose folder the files of the study are not found."""
    from pidpanel.study import StudyError

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
    import pandas as pd
    import yaml

    from pidpanel.provenance import durable
    from pidpanel.provenance.results import read_csv
    from pidpanel.study.document import Document

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
    plain = json.loads(json.dumps({**values, "scenarios": scenarios}))  # numbers know their text
    text = yaml.safe_dump(plain, sort_keys=False, allow_unicode=True)
    head = f"# The best layouts that pidpanel optimise {study.name} proposes.\n"
    durable.write_text(file, head + text)
