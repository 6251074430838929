"""The command line through its entry point: every command, exit code and one-line answer."""

import importlib.metadata
import json
import os
import shlex
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest
import yaml

from pidpanel import cli
from pidpanel.cli import snakemake
from pidpanel.cli.commands import pidpanel
from pidpanel.cli.workflow_process import run_snakemake
from pidpanel.coupon.from_study import cases_of
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.paths import STUDIES
from pidpanel.study import load_any_study, load_study
from pidpanel.study.sound import Wall

(ENTRY,) = importlib.metadata.entry_points(group="console_scripts", name="pidpanel")
main = ENTRY.load()
COMMANDS = [name for name, command in pidpanel.commands.items() if not command.hidden]


def answer(capsys, *arguments):
    """Exit code, output and errors of a command."""
    try:
        code = main([str(one) for one in arguments])
    except SystemExit as error:
        code = error.code
    said = capsys.readouterr()
    return code, said.out, said.err


def refused(capsys, *arguments):
    """Exit code and the one line that a command answers a mistake with."""
    code, out, error = answer(capsys, *arguments)
    assert out == "" and error.count("\n") == 1 and error.endswith("\n"), (out, error)
    return code, error


def test_help_says_what_and_in_which_order(capsys):
    code, out, _ = answer(capsys, "--help")
    assert code == 0
    listed = out.split("Commands:")[1]
    places = [listed.index(f"\n  {name} ") for name in COMMANDS]
    assert places == sorted(places)
    for number in (cli.DONE, cli.FAILED, cli.MISTAKE, cli.MACHINE, cli.INTERRUPTED):
        assert f"\n  {number} " in out
    for name in COMMANDS:
        assert answer(capsys, name, "--help")[0] == 0


def test_help_and_completion_import_nothing_that_is_slow():
    code = (
        "import sys; from pidpanel.cli.commands import pidpanel; import pidpanel;"
        "print([m for m in ('numpy', 'pydantic', 'snakemake', 'xarray') if m in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    assert done.stdout == "[]\n"


@pytest.mark.parametrize(
    ("arguments", "line"),
    [
        ([], "pidpanel: Missing command"),
        (["frobnicate"], "No such command 'frobnicate'"),
        (["run", "l_panel.yaml", "-j", "0"], "'--jobs': 0 is not in the range x>=1"),
        (["run", "l_panel.yaml", "-j", "two"], "'--jobs': 'two' is not a valid integer"),
        (["check", "nowhere.yaml"], "nowhere.yaml: cannot be read"),
        (["deck", "l_panel.yaml"], "l_panel.yaml: runs no LIGGGHTS"),
        (["deck", "smoke.yaml", "r0.4"], "r0.4: 4 cases with this label"),
        (["deck", "smoke.yaml", "r0.4_f100Hz_a10g", "--seed", "9"], "--seed 9: must be one of 1, 2"),
        (["compare", "nowhere", "l_panel.yaml"], "nowhere: must be a study or the folder"),
        (["compare", "l_panel.yaml", "l_panel.yaml"], "results/l_panel: has no response/summary.csv"),
        (["export", "coupon_friction.yaml"], "panel"),
        (["new", "mine.txt"], "mine.txt: must end in .yaml"),
        (["new", "mine.yaml", "--size", "2"], "'--size': '2': must be two lengths in m"),
        (["new", "mine.yaml", "--size", "2x-1"], "'2x-1': must be two lengths in m"),
        (["new", "mine.yaml", "--spectrum", "nope.csv"], "--spectrum nope.csv: no such file"),
        (["new", "mine.yaml", "--hold-down", "0.4"], "'--hold-down': '0.4': must be x,y in m"),
        (["new", "mine.yaml", "--bead", "none", "--hold-down", "4,0.2"], "--hold-down 4,0.2: lies off the panel, 1.5x1.0 m"),
        (["new", "mine.yaml", "--bead", "none", "--budget-kg", "1"], "--budget-kg 1: needs particles or a table"),
        (["new", "mine.yaml", "--bead", "none", "--steady-g", "0,0,-3"], "--steady-g: needs particles"),
        (["new", "mine.yaml", "--attitude", "sideways"], "--attitude"),
        (["new", "mine.yaml", "--shaker", "nope.csv"], "base.random.spectrum"),
        (["new", "mine.yaml", "--core-grade", "foam"], "unknown grade"),
        (["new", "mine.yaml", "--surroundings", "wall"], "'--surroundings': 'wall' is not one of 'free', 'baffle'"),
        (["new", "mine.yaml", "--wall-m", "0.001"], "sound.surroundings.wall_m = 0.001: must be at least a tenth"),
        (["new", "mine.yaml", "--wall-m", "1", "--surroundings", "baffle"], "--wall-m 1: not allowed with --surroundings baffle"),
        (["completion", "tcsh"], "'tcsh' is not one of 'bash', 'zsh', 'fish'"),
        (["check", "l_panel.yaml", "other.yaml"], "unexpected extra argument (other.yaml)"),
        (["check", "l_panel.yaml", "--", "-k"], "only allowed with run"),
        (["export", "l_panel.yaml", "png"], "unexpected argument png"),
        (["new", "mine.yaml", "--budget-kg", "0"], "'--budget-kg': 0.0 is not in the range x>0"),
        (["new", "mine.yaml", "--face-mm", "-1"], "panel.section.faces[0].thickness_mm = -1: must be from"),
    ],
)  # fmt: skip
def test_a_mistake_is_one_line_and_exit_code_2(capsys, tmp_path, monkeypatch, arguments, line):
    monkeypatch.chdir(tmp_path)
    code, said = refused(capsys, *arguments)
    assert code == cli.MISTAKE
    assert line in said
    assert list(tmp_path.iterdir()) == []


def test_what_the_machine_lacks_is_exit_code_3(capsys, tmp_path, monkeypatch):
    monkeypatch.setenv("PATH", str(tmp_path))
    code, said = refused(capsys, "run", "coupon_friction.yaml", "-d", tmp_path)
    assert code == cli.MACHINE
    assert "apt-get install liggghts" in said


def test_a_full_disk_is_one_line(capsys, tmp_path, monkeypatch):
    monkeypatch.setattr(snakemake.shutil, "disk_usage", lambda path: type("U", (), {"free": 1e6}))
    code, said = refused(capsys, "run", "l_panel.yaml", "-d", tmp_path)
    assert code == cli.MACHINE and "the disk is full, 1 MB are free" in said
    with open("/dev/full", "w") as full:
        done = subprocess.run(
            [sys.executable, "-c", "from pidpanel.cli import main; raise SystemExit(main())", "schema"],
            stdout=full, stderr=subprocess.PIPE, text=True, check=False,
        )  # fmt: skip
    assert done.returncode == cli.MACHINE
    assert done.stderr == "no space left on the disk; free some and run the same command again\n"


def test_who_reads_only_the_head_of_the_output_sees_no_error():
    reader, writer = os.pipe()
    os.close(reader)
    done = subprocess.run(
        [sys.executable, "-c", "from pidpanel.cli import main; raise SystemExit(main())", "schema"],
        stdout=writer, stderr=subprocess.PIPE, text=True, check=False,
    )  # fmt: skip
    os.close(writer)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("send", [os.killpg, os.kill], ids=["all", "the command alone"])
def test_ctrl_c_waits_for_snakemake_and_says_how_to_go_on(tmp_path, send):
    code = (
        "import signal, sys; from pathlib import Path; from pidpanel import cli; from pidpanel.cli import snakemake\n"
        "signal.signal(2, signal.default_int_handler)\n"  # a test in the background ignores it
        "sleeper = 'import signal, time, pathlib; signal.signal(2, lambda *a: (time.sleep(3),'"
        ' + \'pathlib.Path("ended").touch(), exit(1))); pathlib.Path("begun").touch(); signal.pause()\'\n'
        "snakemake.command = lambda *a: [sys.executable, '-c', sleeper]\n"
        "sys.exit(cli.main(['run', 'l_panel.yaml', '-n']))"
    )
    process = subprocess.Popen(
        [sys.executable, "-c", code], cwd=tmp_path, stderr=subprocess.PIPE, text=True,
        start_new_session=True,
    )  # fmt: skip
    while not (tmp_path / "begun").exists():
        assert process.poll() is None, process.stderr.read()
        time.sleep(0.05)
    send(process.pid, signal.SIGINT)
    assert process.wait() == cli.INTERRUPTED
    assert (tmp_path / "ended").exists()
    assert process.stderr.read() == "stopped; the same command resumes\n"


def test_ctrl_c_while_snakemake_reads_the_workflow_leaves_no_traceback(tmp_path):
    snakefile = tmp_path / "Snakefile"
    again = "os.kill(os.getpid(), signal.SIGINT); open('ended', 'w')"
    snakefile.write_text(
        f"import os, signal\ntry: os.kill(os.getpid(), signal.SIGINT)\nfinally: {again}\n"
    )
    command = [sys.executable, "-P", "-m", snakemake.PROCESS, "-s", snakefile, "-d", tmp_path]
    done = subprocess.run(
        [*command, "-j1"], capture_output=True, text=True, check=False,
        # a test in the background ignores it
        preexec_fn=lambda: signal.signal(signal.SIGINT, signal.SIG_DFL),
    )  # fmt: skip
    assert done.returncode == cli.INTERRUPTED
    assert (tmp_path / "ended").exists()
    assert "Traceback" not in done.stdout + done.stderr


@pytest.mark.parametrize(("options", "is_limited"), [((), False), (("-e", "slurm"), True)])
def test_jobs_of_this_machine_start_at_any_rate(monkeypatch, options, is_limited):
    called = []
    monkeypatch.setattr("snakemake.cli.args_to_api", lambda args, _: called.append(args) or True)
    assert run_snakemake(["-j1", *options]) == 0
    assert (called[0].max_jobs_per_timespan is not None) is is_limited


def test_a_command_that_was_removed_says_what_takes_its_place(capsys):
    code, said = refused(capsys, "estimate", "l_panel.yaml", "-d", "x")
    assert code == 2 and "check prints the time" in said


def test_check_names_the_study(capsys):
    code, out, _ = answer(capsys, "check", "coupon_friction.yaml")
    assert code == 0 and "coupon_friction" in out and "24" in out


def test_run_hands_study_folder_and_options_to_snakemake(capsys, tmp_path, monkeypatch):
    called = []

    class Done:
        def __init__(self, command):
            called.append(command)

        def wait(self):
            return 7

    monkeypatch.setattr(snakemake.subprocess, "Popen", Done)
    code, _, error = answer(
        capsys, "run", "l_panel.yaml", "-j3", "-d", tmp_path, "--", "--forceall"
    )
    assert (code, error) == (cli.FAILED, "")
    assert called[0][:4] == [sys.executable, "-P", "-m", snakemake.PROCESS]
    # a profile of the package, none of the working folder
    profile = called[0].index("--workflow-profile")
    assert Path(called[0][profile + 1]).is_relative_to(STUDIES.parents[1])
    assert called[0][profile + 2 : profile + 4] == ["--forceall", "-j3"]
    assert called[0][-4:] == [
        "--directory",
        str(tmp_path),
        "--configfile",
        str(STUDIES / "l_panel.yaml"),
    ]


def test_a_deck_is_that_of_the_case_asked_for(capsys):
    _, listed, _ = answer(capsys, "deck", "smoke.yaml")
    lines = listed.splitlines()
    assert len(lines) == 8 and lines[0].endswith("r = 0.4, 100 Hz, 10 g")
    label = next(line for line in lines if "r = 0.8, 400 Hz, 100 g" in line).split("\t")[0]
    code, text, _ = answer(capsys, "deck", "smoke.yaml", label)
    assert code == 0
    case = next(
        c
        for c in cases_of(load_any_study(STUDIES / "smoke.yaml").dampers["acrylic"])
        if c.label == label
    )
    assert text == case.runs[0].deck_text()


def test_the_schema_is_that_of_the_models(capsys):
    code, text, _ = answer(capsys, "schema")
    assert code == 0 and json.loads(text)["$schema"].endswith("2020-12/schema")
    assert "panel" in json.loads(text)["properties"]


@pytest.mark.parametrize("options", [(), ("--budget-kg", "3"), ("--section", "thin")])
def test_particles_of_a_measured_table_weigh_in_a_new_study(capsys, tmp_path, options):
    text = "frequency_hz,loss_factor,particle_mass_per_area_kg_m2\n30,0.2,28\n2000,0.2,28\n"
    (tmp_path / "steel.csv").write_text(text)
    file = tmp_path / "wing.yaml"
    assert answer(capsys, "new", file, "--table", tmp_path / "steel.csv", *options)[0] == 0
    assert "apparent_mass: particles" in file.read_text()
    assert not load_study(file).massless_dampers
    code, out, _ = answer(capsys, "check", file)
    assert code == 0 and "no mass in the computation" not in out


def test_a_new_study_with_a_table_that_is_not_there_is_left_to_the_check(capsys, tmp_path):
    file = tmp_path / "wing.yaml"
    code, _, err = answer(capsys, "new", file, "--table", tmp_path / "none.csv")
    assert "Traceback" not in err and code in (0, 2)


def test_each_command_names_one_that_works_next(capsys, tmp_path):
    file, folder = tmp_path / "my panels" / "panel.yaml", tmp_path / "my results"
    options = ["--size", "0.4x0.3", "--section", "thin", "--bead", "none"]
    code, _, error = answer(capsys, "new", file, *options)
    named = []
    for _ in range(3):
        assert code == 0 and error.count("next: ") == 1
        program, command, *rest = shlex.split(error.split("next: ")[1])
        assert program == "pidpanel"
        named.append(command)
        rest = [word for word in rest if word != "--open"]
        rest += [] if "-d" in rest else ["-d", str(folder)]
        code, _, error = answer(capsys, command, *rest)
    assert named == ["check", "run", "report"]
    assert (folder / "results" / file.stem / "report.html").is_file()


@pytest.mark.parametrize("shell", ["bash", "zsh", "fish"])
def test_completion_knows_every_command(capsys, monkeypatch, shell):
    code, script, _ = answer(capsys, "completion", shell)
    variable = "_PIDPANEL_COMPLETE"
    assert code == 0 and f"{variable}={shell}_complete" in script
    for line, expected in (("pidpanel ", COMMANDS), ("pidpanel export --", ["--figures", "--to"])):
        for name, value in {
            variable: f"{shell}_complete",
            "COMP_WORDS": line,
            "COMP_CWORD": line.split(" ")[-1]
            if shell == "fish"
            else "1"
            if line == "pidpanel "
            else "2",
        }.items():
            monkeypatch.setenv(name, value)
        _, told, _ = answer(capsys)
        assert all(name in told for name in expected)


# ------------------------------------------------------------------------------------ new


@pytest.mark.parametrize(
    ("options", "holds"),
    [
        (["--size", "2.1x1.2", "--bead", "steel", "--oaspl", "145"], {"dampers.steel.particles.density_kg_m3": 7850, "dampers.steel.model": "atlas", "sound.oaspl_db": 145, "panel.section.kind": "sandwich"}),
        (["--section", "thin", "--bead", "none", "--mass-kg-m2", "5.25"], {"panel.section.mass_per_area_kg_m2": 5.25, "dampers.paper.law": "paper_corrected"}),
        (["--section", "solid", "--size", "0.7x0.5", "--table", "acrylic_2mm.csv", "--supports", "clamped"], {"dampers.lab.table": "acrylic_2mm.csv", "panel.supports": "clamped"}),
        (["--hold-down", "0.3,0.2", "--hold-down", "1.2,0.8", "--hole", "0.9,0.3,0.1", "--point", "1.4,0.9", "--bead", "none", "--shaker", "gevs_acceptance.csv"], {"panel.supports.outline": "free", "panel.supports.points.H2.at_m": [1.2, 0.8], "panel.holes.hole 1.diameter_m": 0.1, "panel.points.P3": [1.4, 0.9], "base.random.spectrum": "gevs_acceptance.csv"}),
        (["--section", "thin", "--table", "acrylic_2mm.csv", "--budget-kg", "0.5", "--shaker", "gevs_acceptance.csv"], {"optimise.mass_kg": 0.5, "dampers.lab.table": "acrylic_2mm.csv"}),
        (["--bead", "acrylic", "--budget-kg", "0.5"], {"optimise.mass_kg": 0.5, "dampers.acrylic.model": "atlas"}),
        (["--section", "solid", "--size", "0.7x0.5", "--thickness-mm", "6"], {"damping.coupled.relative_error": 0.03}),
        (["--bead", "acrylic", "--shaker", "gevs_acceptance.csv"], {"dampers.acrylic.model": "atlas"}),
        (["--attitude", "upright"], {"dampers.acrylic.gravity_direction": [1, 0, 0]}),
        (["--attitude", "0,0,1", "--steady-g", "0,0,-3"], {"dampers.acrylic.gravity_direction": [0, 0, 1], "sound.steady_acceleration_g": [0, 0, -3]}),
        (["--title", 'a "b" {0/90}s $x$ : # größe'], {"title": 'a "b" {0/90}s $x$ : # größe'}),
    ],
)  # fmt: skip
def test_a_new_study_is_commented_and_passes_the_check(capsys, tmp_path, options, holds):
    file = tmp_path / "wing.yaml"
    assert answer(capsys, "new", file, *options)[0] == 0
    values = yaml.safe_load(file.read_text())
    for key, value in holds.items():
        found = values
        for part in key.split("."):
            found = found[part]
        assert found == value
    assert file.read_text().count("#") > 8
    assert answer(capsys, "check", file)[0] == 0
    code, said = refused(capsys, "new", file, *options)
    assert code == 2 and "--force overwrites it" in said


@pytest.mark.parametrize(
    ("rows", "fills", "fill"),
    [
        (["0.5,100,900", "0.8,100,1500"], [0.5, 0.7], 0.5),
        (["0.6,100,900"], [0.6], 0.6),
        (["0.75,100,900", "0.85,100,950"], [0.75, 0.85], 0.75),
    ],
)
def test_a_new_study_has_fill_fractions_of_its_table(capsys, tmp_path, rows, fills, fill):
    table = tmp_path / "lab.csv"
    table.write_text("\n".join(["fill_fraction,frequency_hz,equivalent_damping_n_s_m3", *rows]))
    options = ["--section", "thin", "--table", table]
    assert answer(capsys, "new", tmp_path / "a.yaml", *options)[0] == 0
    scenarios = yaml.safe_load((tmp_path / "a.yaml").read_text())["scenarios"]
    assert scenarios["fill"]["fill_fraction"] == fills
    assert scenarios["location"]["fill_fraction"] == fill
    assert answer(capsys, "check", tmp_path / "a.yaml")[0] == 0


@pytest.mark.parametrize("options", [(), ("--section", "solid"), ("--size", "3x2")])
def test_the_mesh_of_a_new_study_shifts_no_resonance_by_a_fraction_of_its_width(tmp_path, options):
    # 0.15 ζ is 0.65 dB beside a resonance
    assert main(["new", str(tmp_path / "a.yaml"), *options]) == 0
    study = load_study(tmp_path / "a.yaml")
    panel = StudiedPanel(study.panel)
    panel.check(study.response.frequency_hz[1])
    size, highest = study.panel.mesh.size_m, study.response.frequency_hz[1]
    shift = panel.elements.frequency_shift(size, highest)
    assert shift < 0.15 * 0.01


def test_an_own_spectrum_is_named_relative_to_the_new_study(capsys, tmp_path, monkeypatch):
    (tmp_path / "studies").mkdir()
    rows = "\n".join(f"{f},120" for f in (100, 125, 160, 200, 250))
    (tmp_path / "own.csv").write_text(f"center_hz,spl_db\n{rows}\n")
    monkeypatch.chdir(tmp_path)
    options = ["--section", "thin", "--bead", "none", "--spectrum", "own.csv"]
    assert answer(capsys, "new", "studies/a.yaml", *options)[0] == 0
    values = yaml.safe_load(Path("studies/a.yaml").read_text())
    assert values["sound"]["spectrum"] == "../own.csv"
    low, high = values["response"]["frequency_hz"]
    assert 89 < low < 90 and 281 < high < 281.84  # edges: 100 · 10^-0.05, 251.19 · 10^0.05


@pytest.mark.parametrize("limit", [100e6, 799e6])
def test_a_limit_on_memory_with_which_nothing_begins_is_one_line(capsys, monkeypatch, limit):
    monkeypatch.setattr(snakemake.resource, "getrlimit", lambda kind: (int(limit), -1))
    code, _, error = answer(capsys, "run", "l_panel.yaml")
    assert code == cli.MACHINE
    assert error.startswith(f"the memory of a process is limited to {limit / 1e6:.0f} MB")
    assert error.count("\n") == 1


def test_a_new_study_of_a_free_panel_has_a_point_and_a_damper_at_its_corner(capsys, tmp_path):
    # with dampers at centre and quarter alone "no reduction beyond its error" was the answer for a
    # panel on hold-downs
    for supports, points, patches in (
        ("free", ["P1", "P2", "corner"], ["centre", "quarter", "outer"]),
        ("clamped", ["P1", "P2"], ["centre", "quarter"]),
    ):
        file = tmp_path / f"{supports}.yaml"
        assert answer(capsys, "new", file, "--supports", supports, "--bead", "none")[0] == 0
        study = load_any_study(file)
        assert list(study.panel.points) == points
        assert list(study.panel.patches) == list(study.scenarios["location"].patch) == patches
        assert study.scenarios["fill"].patch == patches[-1] if supports == "free" else "centre"


def test_a_new_study_says_why_it_is_simulated(capsys, tmp_path):
    message = "because the cell lies outside the atlas: 2 to 10 diameters wide, 4 to 40 deep"
    for size, is_outside in (("3", True), ("2", False)):
        file = tmp_path / f"steel{size}.yaml"
        assert main(["new", str(file), "--bead", "steel", "--bead-mm", size]) == 0
        assert (message in " ".join(file.read_text().split())) is is_outside


@pytest.mark.parametrize(
    ("options", "surroundings", "reference", "radiation"),
    [
        ([], "free", "room", "two_sides"),
        (["--surroundings", "baffle"], "baffle", "surface", "none"),
        (["--wall-m", "0.08"], Wall(wall_m=0.08), "room", "two_sides"),
    ],
)
def test_a_new_panel_hangs_free_unless_told_otherwise(
    capsys, tmp_path, options, surroundings, reference, radiation
):
    file = tmp_path / "mine.yaml"
    assert answer(capsys, "new", file, "--bead", "none", "--section", "thin", *options)[0] == 0
    study = load_study(file)
    assert study.acoustics.surroundings == surroundings
    assert (study.acoustics.reference, study.radiation) == (reference, radiation)
