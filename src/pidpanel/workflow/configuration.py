"""The study that a configuration of Snakemake is, and what results depend on besides files."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib.metadata import version
from pathlib import Path
from typing import Any

import yaml

from pidpanel.check import checked_study
from pidpanel.paths import study_path
from pidpanel.provenance.digests import package_digest
from pidpanel.study import CouponStudy, Study, StudyError
from pidpanel.study.document import Document
from pidpanel.study.values import merged

# Keys of a configuration that are not of a study.
SETTINGS = frozenset({"study", "job_minutes", "container"})


def has_study(config: Mapping[str, Any]) -> bool:
    """Return whether a configuration names a study or is one."""
    return "study" in config or bool(config.keys() - SETTINGS)


def configured_study(
    config: Mapping[str, Any], files: Sequence[str | Path]
) -> tuple[Study | CouponStudy, Path]:
    """Return the study that a configuration is, checked, and its file.

    The file is the one that ``study`` names, or the last of the configuration files. What the
    configuration has beyond it takes the place of its values: further files, ``--config``.

    Parameters
    ----------
    config, files
        All values as Snakemake has put them together, and the files among their sources.

    Raises
    ------
    StudyError
        One line for each mistake.
    """
    values = {key: value for key, value in config.items() if key not in SETTINGS}
    if "study" in config:
        document = Document(study_path(str(config["study"])).resolve())
        return checked_study(_with_values(document, values)), document.path
    if not values:
        raise StudyError(
            "no study: snakemake --configfile study.yaml, or its name in config/config.yaml"
        )
    if not files:
        path = Path("config.yaml").resolve()
        return checked_study(Document(path, "configuration", values)), path
    document = Document(Path(files[-1]).resolve())
    for file in files[:-1]:  # the last one wins, and names the study
        document.data = merged(Document(Path(file).resolve()).data, document.data)
    plain: dict[str, Any] = {}
    for file in files:
        plain = merged(plain, yaml.safe_load(Path(file).read_text(encoding="utf-8")) or {})
    return checked_study(_with_values(document, _differences(plain, values))), document.path


def _with_values(document: Document, values: Mapping[str, Any]) -> Document:
    document.source = f"{document.path}, --config"
    return document.changed(values) if values else document


def _differences(values: Mapping[str, Any], changed: Mapping[str, Any]) -> dict[str, Any]:
    """Return what of changed values is not in values."""
    differences: dict[str, Any] = {}
    for key, change in changed.items():
        value = values.get(key)
        if isinstance(value, Mapping) and isinstance(change, Mapping):
            if section := _differences(value, change):
                differences[key] = section
        elif key not in values or value != change:
            differences[key] = change
    return differences


def package_version() -> str:
    """Return the version of the package, with the digest of its code and tables."""
    return f"{version('pidpanel')}+{package_digest()[:12]}"
