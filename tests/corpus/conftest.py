"""Small studies and files that are right, to be made wrong by one change of their text."""

import re
from pathlib import Path
from typing import NamedTuple

import pytest
import yaml

from pidpanel.check import checked_study
from pidpanel.damping.atlas_files import read_atlas
from pidpanel.identify.from_study import read_measurement
from pidpanel.study import StudyError

HERE = Path(__file__).parent
TEXTS = {path.name: path.read_text(encoding="utf-8") for path in (HERE / "bases").iterdir()}
BASES = {name.removesuffix(".yaml"): TEXTS[name] for name in TEXTS if name.endswith(".yaml")}
BED = "".join(f"  {line}\n" for line in BASES["coupon"].splitlines()[1:])
BASES["full"] = (
    BASES["thin"]
    .replace("  paper: {law: paper_corrected}\n", f"  bed:\n{BED}    model: tones\n")
    .replace("0.5\n", "0.6\n")
)
FILES = {name: text for name, text in TEXTS.items() if not name.endswith(".yaml")}
KINDS = yaml.safe_load((HERE / "wrong.yaml").read_text(encoding="utf-8"))["kinds"]
WITHOUT_KEY = re.compile(r"not YAML|lists and|has \d")
HINTS = (r"not YAML: ([^;:]+)", r"[-\d.e+]+ (\S+) would be ", r"did you mean ([^?]+)\?")


class Place(NamedTuple):
    """A study in a folder of its own, with the files that it names."""

    folder: Path
    study: Path

    def told(self) -> list[str]:
        """The lines of the refusal, none if the study is accepted; without the folder."""
        try:
            if "\nmeasured:" in self.study.read_text(encoding="utf-8", errors="replace"):
                read_measurement(self.study, read_atlas())
            else:
                checked_study(self.study)
        except StudyError as error:
            return str(error).replace(f"{self.folder}/", "").split("\n")
        return []


def replaced(text: str, old: str, new: str) -> str:
    """The text with its only (or first) ``old`` changed; at the end where there is no ``old``."""
    if not old:
        return text + new
    assert old in text, f"not in the base: {old}"
    return text.replace(old, new, 1)


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """Where the files of all studies are; a test leaves it as it was."""
    made = tmp_path_factory.mktemp("corpus")
    for name, text in FILES.items():
        (made / name).write_text(text, encoding="utf-8")
    return made


@pytest.fixture
def written(folder):
    """(text or bytes of the study) → its place."""

    def write(study, name="mine.yaml"):
        path = folder / name
        path.write_bytes(study if isinstance(study, bytes) else study.encode())
        return Place(folder, path)

    return write


@pytest.fixture(scope="session")
def bases():
    return BASES


@pytest.fixture(scope="session")
def files():
    return FILES


@pytest.fixture(scope="session")
def change():
    return replaced


def meaning(text):
    """What a message says after file and line: "key: kind (hint)"."""
    starts = [0] if WITHOUT_KEY.match(text) else [m.end() for m in re.finditer(": ", text)]
    for start in starts:
        for kind, pattern in KINDS.items():
            if re.match(pattern, text[start:]):
                key = re.split(" = |: ", text)[0] + ": " if start else ""
                hints = (re.search(hint, text[start:]) for hint in HINTS)
                hint = next((f" ({match[1]})" for match in hints if match), "")
                return f"{key}{kind}{hint}"
    return text


@pytest.fixture
def wrong(written):
    """Assert that a base with one change is refused with these mistakes, as in wrong.yaml."""

    def check(base, old, new, *mistakes):
        study = replaced(BASES[base], old, new)
        change = BASES[base].index(old)
        expected = []
        for mistake in mistakes:
            mark, mistake = mistake[1:].split("|", 1) if mistake[0] == "@" else (None, mistake)
            place = change if mark is None else study.index(mark) if mark else None
            line = "" if place is None else f":{study[:place].count(chr(10)) + 1}"
            expected.append(f"mine.yaml{line}: {mistake.strip()}")
        told = (line.split(": ", 1) for line in written(study).told())
        assert [f"{place}: {meaning(text)}" for place, text in told] == expected

    return check
