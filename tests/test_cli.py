"""The command line answers in a line."""

from pathlib import Path

from pidpanel.cli import main

STUDIES = Path(__file__).parents[1] / "workflow" / "studies"


def test_check_says_what_a_study_would_run(capsys):
    assert main(["check", str(STUDIES / "smoke.yaml")]) == 0
    assert capsys.readouterr().out == (
        "smoke: 8 coupon cases, 16 runs; 3 scenarios in 2 readings\n"
    )


def test_check_answers_a_mistake_with_one_line_and_status_2(capsys, tmp_path):
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
