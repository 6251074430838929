"""The documents as pages: built without a warning, whole, and as their commands say."""

import ast
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from reference_pages import DOCS

from pidpanel.paths import PROJECT

SOURCES = sorted(path for path in DOCS.rglob("*.md"))
PACKAGE = PROJECT / "src" / "pidpanel"
EXCEPTIONS = {"ValueError", "RuntimeError", "Exception"}


def test_the_pages_are_built_without_a_warning(built):
    folder, done = built
    assert done.returncode == 0, done.stderr
    assert {path.stem for path in SOURCES} <= {path.stem for path in folder.rglob("*.html")}


ROOT_PAGES = [
    *(PROJECT / name for name in ("README.md", "CONTRIBUTING.md", "CHANGELOG.md")),
    *sorted((PROJECT / "benchmarks").glob("*.md")),
]


def anchors_of(page):
    """Anchors of a page's headings, as GitHub makes them."""
    titles = re.findall(r"^#+ (.*)$", page.read_text(encoding="utf-8"), re.MULTILINE)
    return {re.sub(r"[^\w\- ]", "", one.lower()).replace(" ", "-") for one in titles}


@pytest.mark.parametrize("page", ROOT_PAGES, ids=lambda page: page.name)
def test_links_of_the_pages_outside_of_docs_lead_somewhere(page):
    for link in re.findall(r"\]\(([^)\s]+)\)", page.read_text(encoding="utf-8")):
        if "://" in link:
            continue
        path, _, anchor = link.partition("#")
        target = page.parent / path if path else page
        assert target.exists(), link
        assert not anchor or anchor in anchors_of(target), link


def test_every_shipped_study_has_its_row():
    text = (DOCS / "studies.md").read_text(encoding="utf-8")
    for path in (PROJECT / "workflow" / "studies").glob("*.yaml"):
        name = path.stem.replace("coupon_", "_")
        assert path.stem in text or f"`{name}`" in text, path.name


def errors_of_the_package():
    """Names of all classes of the package that are raised, but for what only pages catch."""
    classes = {}
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ClassDef) and node.bases:
                classes[node.name] = [ast.unparse(base).split(".")[-1] for base in node.bases]

    def is_error(name):
        return name in EXCEPTIONS or any(
            is_error(base) for base in classes.get(name, ()) if base != name
        )

    return sorted(name for name in classes if is_error(name))


def test_every_failure_is_on_the_page_of_messages():
    page = (DOCS / "reference" / "messages.md").read_text(encoding="utf-8")
    told = set(re.findall(r"`([A-Z]\w+)`", page))
    # what holds others together, what is told as the lines of a study's mistakes, and the end of
    # one of several jobs of a run
    inner = {"SolverFailure", "StudyError", "Mistakes", "Continues", "UnitError"}
    found = set(errors_of_the_package()) - inner
    assert len(found) > 20
    assert found - told == set()


def texts_of_the_package():
    """All that the package may say: its texts and the fixed parts of those with values."""
    for path in PACKAGE.rglob("*.py"):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Constant) and isinstance(node.value, str):
                yield " ".join(node.value.split())
    for path in (*PACKAGE.rglob("*.html"), *PACKAGE.rglob("*.yaml")):
        yield " ".join(path.read_text(encoding="utf-8").split())


def test_the_page_of_messages_quotes_what_is_said():
    page = (DOCS / "reference" / "messages.md").read_text(encoding="utf-8")
    said = "\n".join(texts_of_the_package())
    quoted = []
    for row in re.findall(r"^\| (.*?) \|", page, re.MULTILINE):
        quoted += re.findall(r"`([a-z][^`]+)`", row) + re.findall(r'"([^"]+)"', row)
    parts = [part.strip(" ,;:?()") for one in quoted for part in re.split(r"…|'\w+'", one)]
    wanted = [part for part in parts if len(part) > 7]
    assert len(wanted) > 40
    assert [part for part in wanted if part not in said] == []


def commands_of(page):
    """(command, what it prints) of the console blocks of a page, in order."""
    text = page.read_text(encoding="utf-8")
    for block in re.findall(r"^```console\n(.*?)^```", text, re.MULTILINE | re.DOTALL):
        for part in re.split(r"^\$ ", block, flags=re.MULTILINE)[1:]:
            command, _, said = part.partition("\n")
            yield command, said


def files_of(page):
    """(name, text) of the files that a page shows in full."""
    text = page.read_text(encoding="utf-8")
    found = re.findall(r"`(mine/[\w.]+)`[^\n]*:\n\n```\w*\n(.*?)^```", text, re.M | re.S)
    return dict(found)


QUICK = ("cp ", "sed ", "pidpanel check ")
CHECKED = [page for page in SOURCES if any(c.startswith(QUICK[2]) for c, _ in commands_of(page))]


@pytest.mark.parametrize("page", CHECKED, ids=lambda page: page.stem)
def test_the_quick_commands_of_a_page_print_what_it_shows(page, tmp_path):
    (tmp_path / "workflow").symlink_to(PROJECT / "workflow")
    (tmp_path / "mine").mkdir()
    # a tutorial goes on with the files of the one before
    for one in SOURCES:
        if one == page or one.parent == page.parent:
            for name, text in files_of(one).items():
                (tmp_path / name).write_text(text, encoding="utf-8")
    path = f"{Path(sys.executable).parent}:{os.environ['PATH']}"
    for command, said in commands_of(page):
        if command.startswith(QUICK):
            done = subprocess.run(
                ["bash", "-c", command],
                cwd=tmp_path,
                env={**os.environ, "PATH": path},
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                text=True,
                check=False,
            )
            assert done.stdout == said, f"{page}: $ {command}"
