"""A study read from its file: checked, or refused with a line for each mistake."""

import re
import unicodedata
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from pydantic import ValidationError

from pidpanel.study.base import SectionModel, StudyError
from pidpanel.study.coupon_study import RESERVED, CouponStudy
from pidpanel.study.document import Document
from pidpanel.study.mistakes import Mistake, mistakes_of
from pidpanel.study.study import Study

T = TypeVar("T", bound=SectionModel)


def load_study(path: str | Path) -> Study:
    """Read and check the file of a study that has a panel; see `load_any_study`."""
    study = load_any_study(path)
    if not isinstance(study, Study):
        raise StudyError(f"{path}: panel: missing; this is a study of the coupon alone")
    return study


def load_any_study(path: str | Path) -> Study | CouponStudy:
    """Read and check a study file.

    Parameters
    ----------
    path
        YAML file. Paths in it are relative to its own folder, to the working folder, or to the
        folder of such files that come with pidpanel.

    Returns
    -------
    Study or CouponStudy
        A `CouponStudy` if the file has a section ``coupon`` and nothing of a panel.

    Raises
    ------
    StudyError
        One line for each mistake: file, line, key, value, what is wrong or what is allowed.
    """
    return study_in(Document(Path(path)))


def study_in(document: Document) -> Study | CouponStudy:
    """Return the study of a file that has been read; see `load_any_study`."""
    of_panel = set(Study.model_fields) - set(CouponStudy.model_fields)
    is_coupon = "coupon" in document.data and not (of_panel - {"damping"}) & set(document.data)
    if is_coupon and "damping" in document.data:
        says = "only in a study with a panel; a study of the coupon alone reads no damping model"
        raise document.error([Mistake(("damping",), f"{says}. Delete it, or add panel and sound")])
    return section_in(document, CouponStudy if is_coupon else Study, _in_file)


def section_in(
    document: Document,
    model: type[T],
    explain: Callable[[Mistake, Document], Mistake] | None = None,
) -> T:
    """Return the model of a whole file; `StudyError` with its mistakes, as they are explained."""
    values = {"name": document.path.stem, **document.data}
    try:
        section = model.model_validate(values, context={"folder": document.path.parent})
    except ValidationError as error:
        mistakes = list(mistakes_of(error, model))
        if explain:
            mistakes = [explain(mistake, document) for mistake in mistakes]
        raise document.error(mistakes) from None
    if document.mistakes:
        raise document.error([])
    return section


def _in_file(mistake: Mistake, document: Document) -> Mistake:
    """Return a mistake with its cause: an indented section, or the name of the file."""
    *around, key = mistake.keys or ("",)
    if around and key in Study.model_fields and mistake.says.startswith("unknown key"):
        says = f"unknown key; {key} is a top-level section; do not indent its line"
        return mistake._replace(says=says)
    if mistake.keys != ("name",) or "name" in document.data:
        return mistake
    stem = document.path.stem
    plain = unicodedata.normalize("NFKD", stem).encode("ascii", "ignore").decode()
    better = re.sub("[^A-Za-z0-9_-]+", "_", plain).strip("_-")
    better = better if better and better not in RESERVED else f"{better or 'my'}_study"
    says = f"missing; the name of the file, {stem!r}, cannot be that of the study: {mistake.says}"
    return mistake._replace(says=f"{says}; such as name: {better}")
