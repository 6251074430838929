"""Files that a study names: beside it, in the working folder, or among those of pidpanel."""

import stat
from pathlib import Path
from typing import Any

from pydantic import AfterValidator, ValidationInfo


def file_in(shipped: Path | None = None) -> AfterValidator:
    """Make a path one of a file that is there, where the folder of the study is known."""

    def find(name: Path, info: ValidationInfo) -> Path:
        context: dict[str, Any] = info.context or {}
        return found_file(name, context["folder"], shipped) if "folder" in context else name

    return AfterValidator(find)


def found_file(name: Path, folder: Path, shipped: Path | None) -> Path:
    """Return the path of a file that a study in a folder names.

    Raises
    ------
    ValueError
        If there is no such file; the files that come with pidpanel are listed.
    """
    for base in (folder, Path.cwd(), shipped):
        if base is None:
            continue
        try:
            mode = (base / name).stat().st_mode
        except (OSError, ValueError):  # not there, a name that is too long, a NUL in it
            continue
        if stat.S_ISDIR(mode):
            raise ValueError("is a folder; must be a file")
        if not stat.S_ISREG(mode):
            raise ValueError("must be a file")
        return base / name
    names = sorted(path.name for path in shipped.glob("*.*")) if shipped else []
    raise ValueError(
        "no such file; must be a path relative to the study"
        + (f", or one of {', '.join(names)}" if names else "")
    )
