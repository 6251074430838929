"""Which study the configuration of Snakemake is."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import yaml

from pidpanel.paths import study_path
from pidpanel.study import Study, StudyError

# Keys of a configuration that are not of a study.
SETTINGS = frozenset({"study", "job_minutes", "container"})


def has_study(config: Mapping[str, Any]) -> bool:
    """Return whether a configuration names a study or is one."""
    return "study" in config or bool(config.keys() - SETTINGS)


def study_file(config: Mapping[str, Any], files: Sequence[str | Path]) -> Path:
    """Return the file of the study that a configuration names or is."""
    if "study" in config:
        name = str(config["study"])
        if values := sorted(config.keys() & Study.model_fields.keys() - SETTINGS):
            raise StudyError(f"{name}: {values[0]}: {ONE_FILE}")
        return study_path(name).resolve()
    keys = sorted(config.keys() - SETTINGS)
    if keys and not files:
        raise StudyError(f"--config {keys[0]}: {NO_VALUE}")
    if not keys:
        raise StudyError(
            "no study: snakemake --configfile study.yaml, or its name in config/config.yaml"
        )
    file = Path(files[-1])
    with file.open(encoding="utf-8") as stream:
        written = yaml.safe_load(stream) or {}
    for key in config.keys() - SETTINGS | written.keys():
        if config.get(key) != written.get(key):
            raise StudyError(f"{file}: {key}: {ONE_FILE}")
    return file.resolve()


ONE_FILE = (
    "the configuration has another value than the file of the study; a study is one file: change "
    "the value there instead of --config or a further --configfile"
)

NO_VALUE = (
    "not a setting, and a study is one file: change the value there, and name the file with "
    "--configfile, --config study=… or in config/config.yaml"
)
