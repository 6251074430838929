"""What every result carries: of which study it is and what made it. No time stamps."""

import json
from collections.abc import Mapping
from importlib.metadata import version
from pathlib import Path
from typing import Any

from pidpanel.constants import LIGGGHTS_VERSION
from pidpanel.fingerprint import file_digest, text_digest
from pidpanel.study import CouponStudy


def stamp(study: CouponStudy) -> dict[str, str]:
    """Return the attributes of a result file.

    Returns
    -------
    dict
        Name of the study, hash of all that it says, versions of pidpanel and LIGGGHTS.
    """
    return {
        "study": study.name,
        "study_hash": text_digest([json.dumps(by_content(study.model_dump()))])[:16],
        "pidpanel_version": version("pidpanel"),
        "liggghts_version": LIGGGHTS_VERSION,
    }


def by_content(value: Any) -> Any:
    """Return values of a study as JSON holds them, each file by the hash of its content.

    A study is the same wherever it and the files that it names are.
    """
    if isinstance(value, Path):
        return file_digest(value)
    if isinstance(value, Mapping):
        return {key: by_content(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [by_content(item) for item in value]
    return value
