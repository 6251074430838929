"""The command line answers in a line."""

from pathlib import Path

import pytest

from pidpanel.cli import main
from pidpanel.coupon.from_study import cases_of
from pidpanel.paths import SNAKEFILE
from pidpanel.study import load_any_study

STUDIES = Path(__file__).parents[1] / "workflow" / "studies"


def test_check_says_what_a_study_would_run(capsys):
    # red: len(cases) for the runs
    assert main(["check", str(STUDIES / "smoke.yaml")]) == 0
    assert capsys.readouterr().out == (
        "smoke: 8 coupon cases, 16 runs; 3 scenarios with damping from paper_corrected, dem\n"
    )
    assert main(["check", str(STUDIES / "coupon_friction.yaml")]) == 0
    assert capsys.readouterr().out == "coupon_friction: 12 coupon cases, 24 runs\n"


def test_check_answers_a_mistake_with_one_line_and_status_2(capsys, tmp_path):
    # red: return 1
    path = tmp_path / "mine.yaml"
    path.write_text((STUDIES / "smoke.yaml").read_text().replace("speed_m_s", "sped_m_s"))
    assert main(["check", str(path)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "sound.sped_m_s = 343: unknown key; did you mean speed_m_s?" in error


def test_an_estimate_without_liggghts_says_what_to_install(capsys, tmp_path, monkeypatch):
    # red: a traceback
    monkeypatch.setenv("PATH", str(tmp_path))
    study = str(STUDIES / "coupon_friction.yaml")
    assert main(["estimate", study, "--results", str(tmp_path)]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "apt-get install liggghts" in error


def test_an_estimate_of_what_is_complete_needs_no_liggghts(capsys, tmp_path, monkeypatch):
    # red: `if True` in place of `if not left`
    study = STUDIES / "coupon_friction.yaml"
    for case in cases_of(load_any_study(study).coupon):
        for path in case.outcomes(tmp_path / "coupon"):
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch()
    monkeypatch.setenv("PATH", str(tmp_path))
    assert main(["estimate", str(study), "--results", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert said == "coupon_friction: no LIGGGHTS runs left, 12 coupon cases are complete\n"


def test_run_hands_the_study_to_snakemake_and_its_status_back(tmp_path, monkeypatch):
    # red: "--configfile" left out; return 0
    study = STUDIES / "l_panel.yaml"
    called = []
    monkeypatch.setattr("subprocess.call", lambda command: called.append(command) or 7)
    assert main(["run", str(study), "-j", "3"]) == 7
    assert called[0][1:] == ["-s", SNAKEFILE, "-j3", "--configfile", study]


@pytest.mark.parametrize("jobs", ["0", "-1", "two"])
def test_a_number_of_jobs_below_one_is_refused(capsys, monkeypatch, jobs):
    # red: type=int
    monkeypatch.setattr("subprocess.call", lambda command: 0)
    with pytest.raises(SystemExit):
        main(["run", str(STUDIES / "l_panel.yaml"), "-j", jobs])
    assert "-j/--jobs" in capsys.readouterr().err


def test_help_names_every_command(capsys):
    # red: help left out of one of them
    with pytest.raises(SystemExit):
        main(["--help"])
    said = " ".join(capsys.readouterr().out.split())
    assert "check Check a study and print what it would run." in said
    assert "run Run a study with Snakemake." in said
    assert "estimate Estimate how long the LIGGGHTS runs of a study take" in said
