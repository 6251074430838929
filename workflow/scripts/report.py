"""Figures and the page: report/*.png, report.html."""

import sys
from pathlib import Path

import pandas as pd

from pidpanel.report import html, tables
from pidpanel.stamp import stamp
from pidpanel.study import load_study

if __name__ == "__main__":
    study_path, folder, coupon = sys.argv[1:]
    folder = Path(folder)
    study = load_study(study_path)
    summary = pd.read_csv(folder / "response" / "summary.csv", dtype={"point": str})
    page = html.Page(
        title=study.title or study.name,
        facts=list(stamp(study).items()),
        assumptions=study.assumptions,
        summary=[],
        warnings=[],
        claims=None,
        sections=[html.Section("response", "Response", [tables.response_table(summary)])],
        steps=[("", f"snakemake -j2 --configfile {study_path}")],
    )
    figures = folder / "report"
    figures.mkdir(exist_ok=True)
    for picture in page.pictures:
        (figures / f"{picture.name}.png").write_bytes(picture.png)
    (folder / "report.html").write_text(html.render(page), encoding="utf-8")
