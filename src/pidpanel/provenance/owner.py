"""Owner of a results folder: two studies of one name would overwrite each other's results."""

import os
from pathlib import Path

from pidpanel.provenance import durable
from pidpanel.provenance.digests import values_digest
from pidpanel.study import CouponStudy, StudyError, load_any_study
from pidpanel.study.document import Document

# File in ``results/<study>`` with the path of the study, relative to ``results``.
#
# So a copied or moved folder holds results of the study that was copied or moved with it, and a
# study that is not there any more, or not on this machine, holds none.
MARK = ".study"


class OwnerError(RuntimeError):
    """Results of another study of the same name are in the way."""


def check_owner(study: CouponStudy, file: Path, results: Path) -> None:
    """Refuse the results of a different study with the same name that still exists.

    Parameters
    ----------
    results
        The folder that holds those of all studies.

    Raises
    ------
    OwnerError
    """
    mark = results / study.name / MARK
    try:
        owner = results.resolve() / mark.read_text(encoding="utf-8").strip()
        if not owner.is_file() or owner.samefile(file):
            return
    except (OSError, ValueError):
        return
    if _is_another(study, owner):
        raise OwnerError(
            f"{file}: {mark.parent} has the results of {owner.resolve()}, another study named "
            f"{study.name}: rename this study or use another --directory, or remove {mark} to "
            "replace them"
        )


def write_owner(study: CouponStudy, file: Path, results: Path) -> None:
    """Note that the results of a study are those of its file."""
    folder = results / study.name
    text = os.path.relpath(file.resolve(), results.resolve())
    folder.mkdir(parents=True, exist_ok=True)
    durable.write_text(folder / MARK, f"{text}\n")


def _is_another(study: CouponStudy, file: Path) -> bool:
    """Return whether a file is a different study with the same name."""
    try:
        if str(Document(file).data.get("name", file.stem)) != study.name:
            return False
    except StudyError:
        return False
    try:
        return values_digest(load_any_study(file).model_dump()) != values_digest(study.model_dump())
    except StudyError:  # one with a mistake in it
        return True
