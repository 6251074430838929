"""A folder that came from somebody else writes nowhere else, runs nothing, and does not wait."""

import os
import shutil
import subprocess
import sys

import pytest

from pidpanel.api import Model
from pidpanel.cli import main
from pidpanel.cli.snakemake import command
from pidpanel.paths import STUDIES
from pidpanel.provenance.links import LinkError, check_links, check_working_folder

STUDY = "l_panel"
PLACES = [  # that are written by the commands, by the rules, by Snakemake and by LIGGGHTS
    f"results/{STUDY}/run.log",
    f"results/{STUDY}/panel.log",
    f"results/{STUDY}/panel",
    f"results/{STUDY}/benchmark",
    f"results/{STUDY}",
    "results/coupon/case/s1/shake_1.log",
    ".snakemake/log",
    ".snakemake",
]


@pytest.fixture()
def received(tmp_path):
    """Folder with a study, and one elsewhere with a file of the user."""
    folder, home = tmp_path / "received", tmp_path / "home"
    folder.mkdir()
    home.mkdir()
    (home / "victim").write_text("mine")
    shutil.copy(STUDIES / f"{STUDY}.yaml", folder)
    shutil.copytree(STUDIES.parent / "data", folder / "data")
    return folder, home


def _commands(folder):
    study = str(folder / f"{STUDY}.yaml")
    for name in ("check", "run", "status", "report", "export", "optimise"):
        yield [name, study, "-d", str(folder)]


@pytest.mark.parametrize("place", PLACES)
def test_no_command_follows_a_link_among_results(received, place, capsys):
    folder, home = received
    path = folder / place
    path.parent.mkdir(parents=True, exist_ok=True)
    is_file = path.suffix == ".log"
    path.symlink_to(home / "victim" if is_file else home)
    for arguments in _commands(folder):
        assert main(arguments) == 2
        assert f"{place}: is a link to" in capsys.readouterr().err
    with pytest.raises(LinkError):
        Model(folder / f"{STUDY}.yaml", folder).run()
    assert [file.name for file in home.iterdir()] == ["victim"]
    assert (home / "victim").read_text() == "mine"


def test_snakemake_alone_follows_no_link_among_results(received):
    folder, home = received
    (folder / "results" / STUDY).mkdir(parents=True)
    (folder / "results" / STUDY / "panel.log").symlink_to(home / "victim")
    call = command(folder / f"{STUDY}.yaml", folder, ["-j1", "--quiet"])
    done = subprocess.run(call, capture_output=True, text=True, check=False)
    assert done.returncode != 0
    assert "panel.log: is a link to" in done.stderr
    assert (home / "victim").read_text() == "mine"


def test_no_command_waits_at_a_pipe_among_results(received, capsys):
    folder, _ = received
    (folder / "results" / STUDY).mkdir(parents=True)
    os.mkfifo(folder / "results" / STUDY / "run.log")
    for arguments in _commands(folder):
        assert main(arguments) == 2
        assert "run.log: must be a file or a folder" in capsys.readouterr().err
    with pytest.raises(LinkError):
        check_links(folder / "results" / STUDY)


def test_results_may_be_a_link_to_another_disk(received):
    folder, home = received
    (folder / "results").symlink_to(home)
    check_working_folder(folder)


def test_folders_nested_without_end_are_looked_through(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for _ in range(1200):
        os.mkdir("d")
        os.chdir("d")
    check_links(tmp_path)
    for _ in range(1200):
        os.chdir("..")
        os.rmdir("d")


@pytest.mark.parametrize("place", [".", ".snakemake/scripts"])
def test_no_module_of_the_working_folder_is_imported(received, place):
    folder, home = received
    (folder / place).mkdir(parents=True, exist_ok=True)
    for name in ("pickle", "numpy", "pidpanel", "snakemake", "json"):
        text = f"open({str(home / 'hit')!r}, 'w')\nraise SystemExit(3)\n"
        (folder / place / f"{name}.py").write_text(text)
    call = command(folder / f"{STUDY}.yaml", folder, [f"results/{STUDY}/panel/modes.nc", "-j1"])
    done = subprocess.run(call, capture_output=True, text=True, check=False, cwd=folder)
    assert not (home / "hit").exists()
    assert done.returncode == 0, done.stderr
    assert sys.executable in call
