"""Digests of what a result depends on: values of a study, content of files, the package."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from functools import cache
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pidpanel.constants import LIGGGHTS_VERSION
from pidpanel.paths import DATA, PACKAGE, TEMPLATES, WORKFLOW

if TYPE_CHECKING:
    from pidpanel.study import CouponStudy


def text_digest(texts: Iterable[str]) -> str:
    """Return the digest of texts in their order: 64 hexadecimal digits."""
    return _joined(text.encode() for text in texts)


def file_digest(*paths: str | Path) -> str:
    """Return the digest of the content of files in their order: 64 hexadecimal digits."""
    return _joined(Path(path).read_bytes() for path in paths)


def _joined(contents: Iterable[bytes]) -> str:
    digest = hashlib.sha256()
    for content in contents:
        digest.update(hashlib.sha256(content).digest())
    return digest.hexdigest()


def json_digest(*values: Any) -> str:
    """Return the digest of values of JSON, independent of the order of their keys."""
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode()).hexdigest()


@cache
def package_digest() -> str:
    """Return the digest of the package, its jobs, decks, page templates and tables.

    Stages that take seconds depend on it. LIGGGHTS runs do not: their labels hold the rendered
    deck and the version numbers of the algorithms (`coupon.cases`).
    """
    pages = PACKAGE / "report" / "pages"
    roots = (
        (PACKAGE, "*.py"), (PACKAGE, "variables.csv"), (PACKAGE, "*.yaml"), (pages, "*"),
        (WORKFLOW / "scripts", "*.py"), (TEMPLATES, "*"), (DATA, "*"),
    )  # fmt: skip
    return text_digest(
        f"{root.name}/{path.relative_to(root).as_posix()} {file_digest(path)}"
        for root, pattern in roots
        for path in sorted(root.rglob(pattern))
        if path.is_file()
    )


def values_digest(values: Any) -> str:
    """Return the digest of values of a study, each file by its content."""
    return text_digest([json.dumps(by_content(values), sort_keys=True)])


def by_content(value: Any) -> Any:
    """Return values of JSON, each path as the digest of its file.

    So a study is the same wherever it and the files that it names are.
    """
    if isinstance(value, Path):
        return file_digest(value)
    if isinstance(value, Mapping):
        return {key: by_content(item) for key, item in value.items()}
    if isinstance(value, list | tuple):
        return [by_content(item) for item in value]
    if error := getattr(value, "error", 0.0):  # of `study.base.Tolerated`
        return {"value": float(value), "error": error}
    return value


def stamp(study: CouponStudy) -> dict[str, str]:
    """Return the attributes that every result file carries; no time stamps.

    Returns
    -------
    dict
        Name and digest of the study, versions of pidpanel and LIGGGHTS, conventions of NetCDF.
    """
    return {
        "study": study.name,
        "study_hash": text_digest([json.dumps(by_content(study.model_dump()))])[:16],
        "pidpanel_version": version("pidpanel"),
        "liggghts_version": LIGGGHTS_VERSION,
        "Conventions": "CF-1.11",
    }
