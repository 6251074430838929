"""What a wheel holds: the package with the workflow, the templates and the data beside it."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

import pidpanel
from pidpanel import cli

ROOT = Path(__file__).parents[1]


def test_a_wheel_holds_all_that_a_run_needs_and_finds_it(tmp_path):
    # of package-data
    command = [sys.executable, "setup.py", "-q", "build_py", "--build-lib", tmp_path / "lib"]
    subprocess.run(
        [*command, "egg_info", "--egg-base", tmp_path], cwd=ROOT, check=True, capture_output=True
    )
    code = (
        "from pidpanel.paths import DATA, PACKAGE, PROJECT, SNAKEFILE, STUDIES, TEMPLATES, WORKFLOW\n"
        "from pidpanel.provenance.digests import package_digest\n"
        "package_digest()\n"
        "print(PACKAGE, PROJECT, SNAKEFILE.is_file(), len(list(DATA.rglob('*.csv'))), sep='|')"
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True,
        env={**os.environ, "PYTHONPATH": str(tmp_path / "lib")},
    )  # fmt: skip
    package, project, there, tables = done.stdout.strip().split("|")
    assert Path(package) == tmp_path / "lib" / "pidpanel"
    assert Path(project) == tmp_path / "lib" / "pidpanel" / "project"
    assert there == "True"
    assert int(tables) == len(list((ROOT / "workflow" / "data").rglob("*.csv")))
    for folder in ("workflow", "templates", "profiles"):
        own = {p.relative_to(ROOT) for p in (ROOT / folder).rglob("*") if p.is_file()}
        own = {p for p in own if not {"__pycache__", ".snakemake"} & set(p.parts)}
        copied = {
            p.relative_to(project) for p in (Path(project) / folder).rglob("*") if p.is_file()
        }
        assert copied == own
    assert (tmp_path / "lib" / "pidpanel" / "py.typed").is_file()
    pages = Path("pidpanel", "report", "pages")
    own, copied = (
        {p.relative_to(root) for p in (root / pages).rglob("*") if p.is_file()}
        for root in (ROOT / "src", tmp_path / "lib")
    )
    assert copied == own and pages / "uplot" / "LICENSE" in own
    for name in ("cases.csv", "datapackage.json"):
        assert (tmp_path / "lib" / "pidpanel" / "atlas" / name).is_file()
    tables = [f"{stage}/variables.csv" for stage in ("base", "panel", "response")]
    for name in (*tables, "study/words.yaml"):
        assert (tmp_path / "lib" / "pidpanel" / name).is_file()


def test_links_of_the_readme_hold_elsewhere_once_a_release_names_its_address(tmp_path):
    command = [sys.executable, "setup.py", "-q", "egg_info", "--egg-base", tmp_path]
    address = "https://host.example/owner/pidpanel/blob/v0.1.0"
    subprocess.run(command, cwd=ROOT, check=True, env={**os.environ, "PIDPANEL_URL": address})
    said = (tmp_path / "pidpanel.egg-info" / "PKG-INFO").read_text()
    # of a picture the file itself: the address of its page shows nothing
    raw = address.replace("/blob/", "/raw/")
    assert f"]({raw}/docs/launch.png)" in said and f"]({address}/docs/launch.png)" not in said
    assert f"]({address}/docs/python.md)" in said
    assert "](docs/" not in said and f"Project-URL: Source, {address.split('/blob/')[0]}" in said


def test_the_image_of_a_cluster_holds_all_that_the_package_is_made_from(tmp_path):
    image = tmp_path / "image"
    recipe = (ROOT / "apptainer.def").read_text()
    for name, place in re.findall(r"^    (\S+) /opt/pidpanel/(\S+)$", recipe, re.MULTILINE):
        copy = shutil.copytree if (ROOT / name).is_dir() else shutil.copy
        image.mkdir(exist_ok=True)
        copy(ROOT / name, image / place)
    command = [sys.executable, "setup.py", "-q", "build_py", "--build-lib", tmp_path / "lib"]
    subprocess.run(command, cwd=image, check=True, capture_output=True)
    # as `pip install --editable` leaves it
    code = (
        "from pidpanel.cli import main\n"
        "main(['new', 'mine.yaml']) or main(['run', '-n', 'paper.yaml', '--', '--quiet'])\n"
        "from pidpanel.paths import PROJECT; print(PROJECT)"
    )
    done = subprocess.run(
        [sys.executable, "-P", "-c", code], cwd=tmp_path, capture_output=True, text=True, check=True,
        env={**os.environ, "PYTHONPATH": str(image / "src")},
    )  # fmt: skip
    assert (tmp_path / "mine.yaml").is_file() and done.stdout.splitlines()[-1] == str(image)


def test_the_version_is_that_of_the_package(capsys):
    assert {"Model", "__version__"} <= set(dir(pidpanel))
    assert cli.main(["--version"]) == 0
    assert capsys.readouterr().out == f"pidpanel {pidpanel.__version__}\n"


@pytest.mark.skipif("PYTEST_XDIST_WORKER" not in os.environ, reason="one process has all tests")
def test_tests_that_share_results_stay_in_one_process(request):
    if request.config.getvalue("loadgroup"):
        assert request.node.nodeid.endswith("@" + str(request.node.path))
