"""Figures and the page of a study of the coupon alone: report/*.png, report.html."""

import os
import sys
from pathlib import Path

from scripts.report import read_coupon

from pidpanel.report import coupon_page, html, style
from pidpanel.stamp import stamp
from pidpanel.study import load_any_study

if __name__ == "__main__":
    study_path, table, coupon, page_path, figures_path = sys.argv[1:]
    # no display is needed; VTK looks for this when the first window is made
    os.environ.setdefault("VTK_DEFAULT_OPENGL_WINDOW", "vtkEGLRenderWindow")
    study = load_any_study(study_path)
    steps = [
        (
            "From the root of the project:",
            f"snakemake -j2 --configfile workflow/studies/{Path(study_path).name}",
        ),
        (f"The table behind this page is results/{study.name}/coupon/cases.csv.", ""),
    ]
    with style.context():
        page = coupon_page.page(
            study, stamp(study), read_coupon(study, Path(table), Path(coupon)), steps
        )
    figures = Path(figures_path)
    figures.mkdir(exist_ok=True)
    for picture in page.pictures:
        (figures / f"{picture.name}.png").write_bytes(picture.png)
    Path(page_path).write_text(html.render(page), encoding="utf-8")
