"""From the files of the stages to a page with its pictures: one function for each page."""

from __future__ import annotations

from pathlib import Path

from pidpanel.paths import SECTION
from pidpanel.provenance import durable
from pidpanel.provenance.digests import stamp
from pidpanel.report import style
from pidpanel.report.coupon_page import coupon_page
from pidpanel.report.facts import files_step, run_step
from pidpanel.report.html import Page, render
from pidpanel.report.read import read_coupon, read_inputs
from pidpanel.report.study_page import study_page
from pidpanel.study import load_any_study, load_study


def write_study_page(
    study_file: Path, folder: Path, coupon: Path, file: Path, figures: Path
) -> None:
    """Write ``report.html`` and ``report/*`` of a study with a panel.

    Parameters
    ----------
    study_file
        The study.
    folder
        Results of the study, ``results/<study>``.
    coupon
        Runs of the coupon, ``results/coupon``.
    file, figures
        The page, and the folder of its figures.

    Raises
    ------
    StudyError
        If the results are not those of the study.
    """
    study = load_study(study_file)
    inputs = read_inputs(study, folder, coupon)
    with style.context():
        page = study_page(inputs, [run_step(study_file), files_step(study, folder)])
    write_page(page, file, figures)


def write_coupon_page(
    study_file: Path, table: Path, coupon: Path, file: Path, figures: Path
) -> None:
    """Write the page and the figures of a study of a coupon alone.

    Parameters
    ----------
    study_file
        The study.
    table
        ``coupon/cases.csv`` of the study.
    coupon
        Runs of the coupon, ``results/coupon``.
    file, figures
        The page, and the folder of its figures.

    Raises
    ------
    StudyError
        If the table is not that of the study.
    """
    study = load_any_study(study_file)
    inputs = read_coupon(study, SECTION, table, coupon)
    files = f"The numbers of this report are in results/{study.name}/coupon/cases.csv."
    with style.context():
        page = coupon_page(study, stamp(study), inputs, [run_step(study_file), (files, "")])
    write_page(page, file, figures)


def write_page(page: Page, file: Path, figures: Path) -> None:
    """Write a page, and each of its pictures as ``<name>.<format>``."""
    figures.mkdir(exist_ok=True)
    for picture in page.pictures:
        (figures / f"{picture.name}.{picture.format}").write_bytes(picture.image)
    durable.write_text(file, render(page))
