"""A study read from its file: checked, or refused with a line for each mistake."""

from __future__ import annotations

import math
import re
import unicodedata
from collections.abc import Mapping
from pathlib import Path
from typing import Any, TypeVar

from pydantic import TypeAdapter, ValidationError

from pidpanel.study.base import SectionModel, StudyError
from pidpanel.study.coupon import Coupon
from pidpanel.study.coupon_study import RESERVED, CouponStudy
from pidpanel.study.dampers import Damper
from pidpanel.study.damping import Damping
from pidpanel.study.document import Document
from pidpanel.study.explaining import mistakes_of
from pidpanel.study.mistakes import Mistake
from pidpanel.study.panel import Panel
from pidpanel.study.response import Response
from pidpanel.study.scenarios import Compared
from pidpanel.study.sound import Sound
from pidpanel.study.study import Study

Section = TypeVar("Section", bound=SectionModel)


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
    study, mistakes = validated(document)
    if study is None or document.mistakes:
        raise document.error(mistakes)
    return study


def validated(document: Document) -> tuple[Study | CouponStudy | None, list[Mistake]]:
    """Return the study of a file, or None and its mistakes but those of the document itself."""
    of_panel = set(Study.model_fields) - set(CouponStudy.model_fields)
    is_coupon = "coupon" in document.data and not (of_panel - {"damping"}) & set(document.data)
    if is_coupon and "damping" in document.data:
        says = "only in a study with a panel; a study of the coupon alone reads no damping model"
        return None, [Mistake(("damping",), f"{says}. Delete it, or add panel and sound")]
    model = CouponStudy if is_coupon else Study
    values = {"name": document.path.stem, **document.data}
    try:
        return model.model_validate(values, context={"folder": document.path.parent}), []
    except ValidationError as error:
        return None, [_of_file_name(mistake, document) for mistake in mistakes_of(error, Study)]


def good_sections(document: Document) -> tuple[Panel | None, Sound | None, Response | None]:
    """Return the sections of a study that is refused that are good on their own."""
    context = {"folder": document.path.parent}

    def section(model: type[Section], name: str) -> Section | None:
        try:
            return model.model_validate(document.data.get(name, {}), context=context)
        except ValidationError:
            return None

    return section(Panel, "panel"), section(Sound, "sound"), section(Response, "response")


def partial_study(document: Document) -> tuple[Study, list[Mistake]]:
    """Return what is right of a study that is refused, and the mistakes between its sections.

    A section that is wrong in itself counts with the names that it gives to others: patches and
    dampers. What rests on more of it is not known yet.
    """
    data, context = document.data, {"folder": document.path.parent}

    def good(kind: Any, value: Any) -> Any:
        try:
            return TypeAdapter(kind).validate_python(value, context=context)
        except ValidationError:
            return None

    panel, coupon = good(Panel, data.get("panel")), good(Coupon, data.get("coupon"))
    patches = _named(_named(data.get("panel")).get("patches"))
    dampers = {name: good(Damper, item) for name, item in _named(data.get("dampers")).items()}
    damping, response = good(Damping, data.get("damping", {})), good(Response, data.get("response"))
    scenarios = {name: good(Compared, item) for name, item in _named(data.get("scenarios")).items()}
    unknown: dict[str, Any] = {"patches": patches, "frequency_hz": (0.0, math.inf)}
    study = Study.model_construct(
        name=document.path.stem,
        panel=panel or Panel.model_construct(**unknown),
        coupon=coupon or (Coupon.model_construct(**unknown) if "coupon" in data else None),
        dampers={name: damper or Damper.model_construct() for name, damper in dampers.items()},
        damping=damping or Damping(),
        response=response or Response.model_construct(**unknown),
        scenarios={name: scenario for name, scenario in scenarios.items() if scenario is not None},
        sound=good(Sound, data.get("sound")) or Sound.model_construct(spectrum=Path()),
    )
    of_fills = damping is not None and None not in dampers.values()
    of_fills = of_fills and (coupon is not None or "coupon" not in data)
    mistakes = list(study.mistakes_of_scenarios(of_fills=of_fills)) if panel or patches else []
    return study, mistakes


def _named(section: Any) -> dict[str, Any]:
    """Return the entries of a section; none of what is no mapping."""
    return dict(section) if isinstance(section, Mapping) else {}


def _of_file_name(mistake: Mistake, document: Document) -> Mistake:
    """Return a mistake of the name with where it comes from, if that is the file."""
    if mistake.keys != ("name",) or "name" in document.data:
        return mistake
    stem = document.path.stem
    plain = unicodedata.normalize("NFKD", stem).encode("ascii", "ignore").decode()
    better = re.sub("[^A-Za-z0-9_-]+", "_", plain).strip("_-")
    better = better if better and better not in RESERVED else f"{better or 'my'}_study"
    says = f"missing; the name of the file, {stem!r}, cannot be that of the study: {mistake.says}"
    return mistake._replace(says=f"{says}; such as name: {better}")
