"""How far a run has come, as `pidpanel status` tells it."""

import json

from pidpanel.cli import progress
from pidpanel.cli.snakemake import is_running, release
from pidpanel.coupon.from_study import cases_of
from pidpanel.paths import STUDIES
from pidpanel.study import load_any_study


def test_status_counts_cases_by_how_they_ended(tmp_path):
    study = load_any_study(STUDIES / "coupon_friction.yaml")
    cases = cases_of(study.coupon)
    for case, ends in zip(cases, (["ok", "ok"], ["ok", "UnderFilled"]), strict=False):
        path = case.outcome_file(tmp_path)
        path.parent.mkdir(parents=True)
        path.write_text(json.dumps({"runs": [{"status": status} for status in ends]}))
    found = progress.case_line(study, tmp_path)
    assert found == "2 of 12 done, 10 left; 1 of them failed (1 UnderFilled)"


def test_status_tells_stages_and_what_failed_last(tmp_path):
    study = load_any_study(STUDIES / "l_panel.yaml")
    lines = list(progress.stages(study, {"maps": 1, "report": 1}))
    assert [line.split() for line in lines[:2]] == [["panel", "done"], ["sound", "done"]]
    assert "left: 1 × maps" in lines[2] and "left: 1 × report" in lines[3]
    logs = tmp_path / ".snakemake" / "log"
    logs.mkdir(parents=True)
    (tmp_path / "results" / "l_panel").mkdir(parents=True)
    (tmp_path / "results" / "l_panel" / "maps.log").write_text("first\nno space left\n\n")
    blocks = [
        f"Error in rule {rule}:\n    jobid: 2\n    log: {log} (check log file(s) for error details)\n"
        for rule, log in (
            ("maps", "results/l_panel/maps.log"),
            ("sound", "results/l_panel/sound.log"),
            ("maps", "results/other/maps.log"),
        )
    ]
    (logs / "new.log").write_text("".join(blocks))
    found = progress.failed(tmp_path, "l_panel", {"maps": 1})
    assert found == ["failed: maps, results/l_panel/maps.log: no space left"]


def test_a_run_in_progress_is_told_from_one_that_has_ended_or_was_killed(tmp_path):
    lock = tmp_path / ".snakemake" / "locks" / "0.output.lock"
    log = tmp_path / ".snakemake" / "log" / "now.log"
    for path in (lock, log):
        path.parent.mkdir(parents=True)
        path.touch()
    with log.open("a"):
        assert is_running(tmp_path)
        release(tmp_path)
        assert lock.exists()
    assert not is_running(tmp_path)
    release(tmp_path)
    assert not lock.exists()


def test_status_has_every_stage_of_a_study():
    design = load_any_study(STUDIES / "design_launch.yaml")
    assert "optimise" in progress.stage_names(design)
    shaker = load_any_study(STUDIES / "shaker.yaml")
    assert "base" in progress.stage_names(shaker)


def test_status_has_coupled_runs_before_the_response_and_their_packings():
    study = load_any_study(STUDIES / "layouts.yaml")
    lines = list(progress.stages(study, {"pour": 3, "coupled_scenario": 4, "coupled": 1}))
    stages = [line.split()[0] for line in lines]
    assert stages == ["coupon", "panel", "sound", "coupled", "response", "report"]
    assert lines[0].endswith("left: 3 × pour")
    assert lines[3].endswith("left: 4 × coupled_scenario, 1 × coupled")


def test_status_has_a_row_of_every_optional_stage():
    study = load_any_study(STUDIES / "design_launch.yaml")
    lines = list(progress.stages(study, {"optimise": 1}))
    assert [line.split()[0] for line in lines] == [
        "panel", "sound", "response", "optimise", "report"
    ]  # fmt: skip
    assert lines[3].split() == ["optimise", "left:", "1", "×", "optimise"]
    assert lines[0].split() == ["panel", "done"]
