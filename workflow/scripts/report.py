"""Figures and the page: report/*.png, report.html."""

import json
import os
import sys
from pathlib import Path

import pandas as pd
import xarray as xr

from pidpanel.coupon.from_study import cases_of
from pidpanel.damping.surface import DampingSurface
from pidpanel.panel.basis_files import read_basis
from pidpanel.report import evidence, html, sections, style
from pidpanel.report.damping_section import DampingResults
from pidpanel.report.inputs import Coupon, Inputs
from pidpanel.stamp import stamp
from pidpanel.study import load_study

PROJECT = Path(__file__).resolve().parents[2]

STEADINESS_SHOWN = 6


def read_coupon(study, table, folder):
    """Cases, the cycles of a few, the spheres of one."""
    cases = pd.read_csv(table, keep_default_na=True)
    known = {case.label: case for case in cases_of(study.coupon)}
    if unknown := sorted(set(cases["case"]) - set(known)):
        sys.exit(f"{table}: {unknown[0]}: not a case of this study as it stands; run it again")
    pictured = evidence.nearest_case(cases)
    sizes = {case.point.packing.diameter for case in known.values()}
    return Coupon(
        cases,
        [
            evidence.read_records(known[label], folder, with_size=len(sizes) > 1)
            for label in evidence.spread_cases(cases, STEADINESS_SHOWN)
        ],
        evidence.read_beads(known[pictured], folder),
    )


def read_rounds(folder):
    """The rounds of the design up to the one that wants no more."""
    rounds = []
    while not rounds or rounds[-1]["new"]:
        rounds.append(json.loads((folder / f"round{len(rounds)}.json").read_text()))
    return rounds


def read_damping(study, folder):
    """What the damping stage left."""
    with xr.open_dataset(folder / "damping" / "surface.nc", engine="scipy") as dataset:
        surface = DampingSurface.from_dataset(dataset.load())
    return DampingResults(
        surface,
        pd.read_csv(folder / "damping" / "law.csv"),
        pd.read_csv(folder / "damping" / "forms.csv"),
        pd.read_csv(folder / "coupon" / "cases.csv", keep_default_na=True),
        study.coupon.cell.depth,
        read_rounds(folder / "design") if study.damping.target else (),
    )


if __name__ == "__main__":
    study_path, folder, coupon, printed = sys.argv[1:]
    folder = Path(folder)
    # no display is needed; VTK looks for this when the first window is made
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    study = load_study(study_path)
    with xr.open_dataset(folder / "response" / "psd.nc", engine="scipy") as dataset:
        psd = dataset.load()
    with xr.open_dataset(folder / "response" / "maps.nc", engine="scipy") as dataset:
        maps = dataset.load()
    beside = folder / "response" / "radiation.csv"
    asked = study.response.radiation_beside != "none"
    inputs = Inputs(
        study=study,
        stamp=stamp(study),
        summary=pd.read_csv(folder / "response" / "summary.csv", dtype={"point": str}),
        psd=psd,
        modes=pd.read_csv(folder / "panel" / "modes.csv"),
        basis=read_basis(folder / "panel" / "modes.nc"),
        section=pd.read_csv(folder / "panel" / "section.csv"),
        bands=pd.read_csv(folder / "sound" / "spectrum.csv"),
        printed=pd.read_csv(printed, comment="#"),
        coupon=read_coupon(study, folder / "coupon" / "cases.csv", Path(coupon))
        if study.coupon
        else None,
        stress=pd.read_csv(folder / "response" / "stress.csv", dtype={"point": str}),
        maps=maps,
        radiation=pd.read_csv(beside, dtype={"point": str}) if asked else None,
        damping=read_damping(study, folder) if "dem" in study.damping.readings else None,
    )
    file = Path(study_path).resolve()
    if file.is_relative_to(PROJECT):
        file = file.relative_to(PROJECT)
    steps = [
        ("From the root of the project:", f"make run STUDY={file}"),
        (
            f"Tables and fields behind this page lie in results/{study.name}: coupon/cases.csv, "
            "damping/surface.nc, damping/law.csv, damping/forms.csv, panel/modes.csv, "
            "panel/modes.vtu, panel/mesh.msh, panel/section.csv, "
            "sound/spectrum.csv, response/psd.nc, response/summary.csv, response/stress.csv; "
            "the figures in report/. "
            "Files carry the hash of the study and the versions, no time stamps.",
            "",
        ),
    ]
    with style.context():
        page = sections.page(inputs, steps)
    figures = folder / "report"
    figures.mkdir(exist_ok=True)
    for picture in page.pictures:
        (figures / f"{picture.name}.png").write_bytes(picture.png)
    (folder / "report.html").write_text(html.render(page), encoding="utf-8")
