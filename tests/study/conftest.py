"""A study file whose lines are known without reading it."""

import json
import tempfile
from pathlib import Path
from typing import NamedTuple

import pytest

from pidpanel.study import StudyError, load_any_study


class Written(NamedTuple):
    """A study file, and the line of every key by the way to it."""

    path: Path
    line: dict


def written(folder, values, quoted=True):
    """Write each key on a line of its own, and lists on the line of their key."""
    lines, line = [], {}

    def add(values, way):
        for key, value in values.items():
            name = json.dumps(key, ensure_ascii=False) if quoted else key
            line[(*way, key)] = len(lines) + 1
            if isinstance(value, dict) and value:
                lines.append(f"{'  ' * len(way)}{name}:")
                add(value, (*way, key))
            else:
                text = json.dumps(value, ensure_ascii=False)
                lines.append(f"{'  ' * len(way)}{name}: {text}")

    add(values, ())
    path = Path(folder) / "mine.yaml"
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return Written(path, line)


@pytest.fixture(scope="session")
def write():
    return written


@pytest.fixture(scope="session")
def refusal():
    """Lines of the refusal of a study, without its folder, and the lines of its keys."""

    def refuse(values, quoted=True):
        with tempfile.TemporaryDirectory() as folder:
            path, line = written(folder, values, quoted)
            with pytest.raises(StudyError) as caught:
                load_any_study(path)
            return str(caught.value).replace(f"{folder}/", "").split("\n"), line

    return refuse
