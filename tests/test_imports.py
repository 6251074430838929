"""Imports point one way: downstream from upstream, and four stages not to each other at all."""

import ast
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "src" / "pidpanel"
STAGES = ("coupon", "damping", "panel", "sound", "response", "coupled", "report")
ALLOWED = {
    "coupon": set(),
    "damping": set(),
    "panel": set(),
    "sound": set(),
    "response": {"coupon", "damping", "panel", "sound"},
    "coupled": {"coupon", "damping", "panel", "sound", "response"},
    "report": {"coupon", "damping", "panel", "sound", "response", "coupled"},
}


def imported(path):
    """(module, line) of every import of the package in a file, lazy ones included."""
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            names = [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            names = [node.module or ""]
            if node.module == "pidpanel":
                names = [f"pidpanel.{alias.name}" for alias in node.names]
        else:
            continue
        yield from ((name, node.lineno) for name in names if name.startswith("pidpanel."))


def trespasses(folder, stages):
    for path in sorted(folder.rglob("*.py")):
        stage = path.relative_to(folder).parts[0].removesuffix(".py")
        if stage not in stages:
            continue
        for module, line in imported(path):
            other = module.split(".")[1]
            if other in stages and other != stage and other not in ALLOWED[stage]:
                yield f"{path.relative_to(folder)}:{line}: {stage} imports {other}"


def test_stages_import_only_what_lies_upstream():
    assert list(trespasses(PACKAGE, STAGES)) == []


def test_a_trespass_is_seen_and_named(tmp_path):
    (tmp_path / "panel").mkdir()
    (tmp_path / "panel" / "mesh.py").write_text("def f():\n    from pidpanel.sound import field\n")
    assert list(trespasses(tmp_path, STAGES)) == ["panel/mesh.py:2: panel imports sound"]


def test_every_stage_has_its_name_in_four_places():
    root = PACKAGE.parents[1]
    for stage in STAGES:
        assert (root / "workflow" / "rules" / f"{stage}.smk").is_file(), stage
        assert (PACKAGE / stage / "__init__.py").is_file(), stage
        assert (root / "tests" / stage).is_dir(), stage


def test_every_stage_has_one_door_for_the_study():
    # red: `from pidpanel.study import Study` in response/tables.py
    knowing = {"api.py", "check.py", "overview.py", "provenance/digests.py", "provenance/owner.py"}
    # the files of the response and the rounds of tones are made through its door
    files = ("results", "rounds", "trust", "verdict_files")
    knowing |= {f"response/{name}.py" for name in files}
    for path in PACKAGE.rglob("*.py"):
        name = str(path.relative_to(PACKAGE))
        if name.startswith(("report/", "study/", "cli/", "workflow/")) or name.endswith(
            "/from_study.py"
        ):
            continue  # the report tells the study
        reads = any(module.startswith("pidpanel.study") for module, _ in imported(path))
        assert not reads or name in knowing, name


def test_no_stage_imports_the_door_of_another_but_downstream():
    # red: `from pidpanel.sound import from_study` in panel/plate.py
    for path in PACKAGE.rglob("*.py"):
        name = path.relative_to(PACKAGE)
        for module, line in imported(path):
            if module.endswith(".from_study") and name.parts[0] in STAGES[:-3]:
                assert module.split(".")[1] == name.parts[0], f"{name}:{line}"
