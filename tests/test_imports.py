"""Imports point one way: downstream from upstream, and four stages not to each other at all."""

import ast
import subprocess
import sys
from pathlib import Path

PACKAGE = Path(__file__).parents[1] / "src" / "pidpanel"
STAGES = (
    "coupon",
    "damping",
    "panel",
    "sound",
    "response",
    "base",
    "energy",
    "coupled",
    "optimise",
    "margin",
    "severity",
    "measurement",
    "report",
)
SHARED = {"atlas", "geometry", "spectra", "study"}
UPSTREAM = {"coupon", "damping", "panel", "sound", "solve", "structure"} | SHARED
ALLOWED = {
    "nastran": set(),
    "atlas": set(),
    "geometry": set(),
    "spectra": set(),
    "study": {"geometry", "spectra"},
    "coupon": SHARED,
    "damping": SHARED,
    "modal_files": {"geometry", "nastran"},
    "panel": SHARED | {"nastran"},
    "shell": SHARED | {"panel", "nastran"},
    "sound": SHARED,
    "solve": {"geometry", "panel", "spectra"},
    "structure": SHARED | {"panel", "shell", "modal_files", "solve"},
    "response": UPSTREAM,
    "base": UPSTREAM | {"response"},
    "energy": UPSTREAM | {"response"},
    "coupled": UPSTREAM,
    "optimise": UPSTREAM | {"response", "base", "severity"},
    "margin": UPSTREAM | {"response", "measurement"},
    "severity": UPSTREAM | {"response", "base"},
    "measurement": UPSTREAM | {"response", "base"},
    "identify": UPSTREAM | {"measurement"},
    "report": UPSTREAM
    | {
        "response",
        "energy",
        "base",
        "coupled",
        "optimise",
        "margin",
        "severity",
        "measurement",
        "identify",
    },
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


def trespasses(folder):
    for path in sorted(folder.rglob("*.py")):
        package = path.relative_to(folder).parts[0].removesuffix(".py")
        if package not in ALLOWED:
            continue
        for module, line in imported(path):
            source = module.split(".")[1]
            if source in ALLOWED and source not in {package, *ALLOWED[package]}:
                yield f"{path.relative_to(folder)}:{line}: {package} imports {source}"


def test_packages_import_only_what_lies_upstream():
    assert list(trespasses(PACKAGE)) == []


def test_every_stage_has_its_name_in_four_places():
    root = PACKAGE.parents[1]
    for stage in STAGES:
        assert (root / "workflow" / "rules" / f"{stage}.smk").is_file(), stage
        assert (PACKAGE / stage / "__init__.py").is_file(), stage
        assert (root / "tests" / stage).is_dir(), stage


def test_every_stage_has_one_door_for_the_study():
    knowing = {"api.py", "check.py", "check_tables.py", "provenance/digests.py", "provenance/files.py",
               "report/names.py"}  # fmt: skip
    for path in PACKAGE.rglob("*.py"):
        name = str(path.relative_to(PACKAGE))
        if name.startswith(("study/", "cli/", "workflow/")) or name.endswith("/from_study.py"):
            continue
        reads = any(module.startswith("pidpanel.study") for module, _ in imported(path))
        assert not reads or name in knowing, name


def test_no_stage_imports_the_door_of_another_but_downstream():
    for path in PACKAGE.rglob("*.py"):
        name = path.relative_to(PACKAGE)
        for module, line in imported(path):
            if module.endswith(".from_study") and name.parts[0] in STAGES[:4]:
                assert module.split(".")[1] == name.parts[0], f"{name}:{line}"


def test_the_panel_of_a_study_is_meshed_without_the_libraries_of_files_and_figures():
    slow = "pandas", "xarray", "matplotlib", "pyvista", "snakemake", "scipy.optimize"
    code = f"import sys, pidpanel.panel.from_study; print(sys.modules.keys() & {set(slow)})"
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert run.stdout == "set()\n"
