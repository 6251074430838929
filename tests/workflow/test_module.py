"""The workflow as a module of another one, as the workflow catalogue deploys it."""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pandas as pd
import pytest
import yaml

from tests.commands import call, jobs, said
from tests.workflow.test_workflow import ROOT

PAGE = (ROOT / "config" / "README.md").read_text(encoding="utf-8")


def shown(heading):
    """The Snakefile that the page shows below a heading, with the workflow of this checkout."""
    section = PAGE.split(f"## {heading}\n")[1].split("\n## ")[0]
    text = "\n\n".join(re.findall(r"^```python\n(.*?)^```", section, re.MULTILINE | re.DOTALL))
    github = re.compile(r"github\([^)]*\)")
    return github.sub('"workflow/Snakefile"', text).replace(
        '"workflow/Snakefile"', repr(str(ROOT / "workflow" / "Snakefile"))
    )


def dry_run(folder, *options):
    result = call("-n", "-d", folder, *options)
    assert result.returncode == 0, said(result)
    return said(result)


def test_another_workflow_takes_all_rules_for_the_study_that_it_names(tmp_path):
    (tmp_path / "config").mkdir()
    config = (ROOT / "config" / "config.yaml").read_text()
    (tmp_path / "config" / "config.yaml").write_text(config)
    snakefile = tmp_path / "Snakefile"
    snakefile.write_text(shown("As a module of another workflow"))
    said = dry_run(tmp_path, "-s", snakefile)
    name = Path(yaml.safe_load(config)["study"]).stem
    assert f"results/{name}/report.html" in said
    assert "pidpanel_response" in said and "rule mine" in said


def test_several_studies_in_one_dag_have_results_of_their_own(tmp_path, write_study, table_values):
    stiff = table_values()
    stiff["panel"]["section"]["bending_stiffness_n_m"] = 5000
    for name, values in (("door", table_values()), ("wing", stiff)):
        write_study(tmp_path, name, values)
    snakefile = tmp_path / "Snakefile"
    snakefile.write_text(shown("Several studies in one DAG"))
    options = ["-s", snakefile, "-d", tmp_path, "-j2"]
    planned = jobs(call(*options, "-n"))
    assert planned["both"] == planned["door_report"] == planned["wing_report"] == 1
    tables = [f"results/{name}/panel/modes.csv" for name in ("door", "wing")]
    result = call(*options, *tables)
    assert result.returncode == 0, said(result)
    door, wing = (pd.read_csv(tmp_path / table)["frequency_hz"][0] for table in tables)
    assert wing / door == pytest.approx((5000 / 3273.07) ** 0.5, rel=1e-3)


def test_a_sweep_over_a_key_is_a_module_for_each_value(tmp_path, write_study, table_values):
    write_study(tmp_path, "small", table_values())
    (tmp_path / "Snakefile").write_text(shown("A sweep over keys").split("ruleorder")[0])
    result = call("-s", tmp_path / "Snakefile", "-d", tmp_path, "-j2")
    assert result.returncode == 0, said(result)
    low, high = (
        pd.read_csv(tmp_path / f"results/{name}/response/summary.csv")["acceleration_rms_g"]
        for name in ("low", "high")
    )
    assert (high < low).all()


def test_variants_of_a_simulated_study_share_its_runs(tmp_path):
    shutil.copy(ROOT / "workflow" / "studies" / "smoke.yaml", tmp_path / "small.yaml")
    (tmp_path / "Snakefile").write_text(shown("A sweep over keys"))
    planned = jobs(call("-n", "-s", tmp_path / "Snakefile", "-d", tmp_path, "-j2"))
    assert planned["low_shake"] > 0 and "high_shake" not in planned
    assert planned["low_response"] == planned["high_response"] == 1


def test_the_catalogue_finds_what_it_asks_for():
    usage = yaml.safe_load((ROOT / ".snakemake-workflow-catalog.yml").read_text())["usage"]
    assert usage["software-stack-deployment"]["apptainer"] is True and usage["report"] is True
    for name in ("workflow/Snakefile", "config/README.md", "config/config.yaml", "LICENSE"):
        assert (ROOT / name).is_file(), name
    assert 'include: "workflow/Snakefile"' in (ROOT / "Snakefile").read_text()


# ------------------------------------------------------------------ configuration


STUDY = ROOT / "workflow" / "studies" / "l_panel.yaml"


def refusal(folder, *options):
    """What Snakemake says where it refuses the configuration."""
    result = call("-n", "-s", ROOT / "Snakefile", "-d", folder, *options)
    assert result.returncode != 0 and "Traceback" not in said(result)
    return said(result)


def test_config_yaml_names_the_study_of_plain_snakemake(tmp_path):
    (tmp_path / "config").mkdir()
    shutil.copy(STUDY, tmp_path / "config" / "mine.yaml")
    (tmp_path / "config" / "config.yaml").write_text("study: config/mine.yaml\n")
    assert "results/mine/report.html" in dry_run(tmp_path, "-s", ROOT / "Snakefile")
    # and not where a study is given
    named = dry_run(tmp_path, "-s", ROOT / "Snakefile", "--configfile", STUDY)
    assert "results/l_panel/report.html" in named


def test_a_study_may_be_named_and_settings_given_on_the_command_line(tmp_path):
    options = ["-s", ROOT / "Snakefile", "--config", f"study={STUDY}", "job_minutes=25"]
    assert "results/l_panel/report.html" in dry_run(tmp_path, *options)


def test_without_a_study_one_line_says_how_to_name_it(tmp_path):
    assert "no study: snakemake --configfile study.yaml" in refusal(tmp_path)


@pytest.mark.parametrize(
    ("value", "line"),
    [
        ("panel={damping_ratio: 5}", "--config: panel.damping_ratio = 5: "),
        ("panl={damping_ratio: 0.02}", "--config: panl = "),
        ("sound={sped_m_s: 300}", "--config: sound.sped_m_s = 300: unknown key"),
    ],
)
def test_a_mistake_in_a_value_of_the_command_line_names_it(tmp_path, value, line):
    options = ["--configfile", STUDY, "--config", value]
    assert f"{STUDY}, {line}" in refusal(tmp_path, *options)


def test_a_profile_in_the_working_folder_is_not_evaluated(tmp_path):
    profile = tmp_path / "profiles" / "default" / "config.yaml"
    profile.parent.mkdir(parents=True)
    hit = tmp_path / "hit"
    profile.write_text(
        f"__use_yte__: true\nnolock: true\n?open({str(hit)!r}, 'w').close() or 'quiet': all\n"
    )
    pidpanel = [Path(sys.executable).with_name("pidpanel"), "run", "-n", "l_panel.yaml"]
    done = subprocess.run(pidpanel, cwd=tmp_path, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "panel" in done.stdout + done.stderr and not hit.exists()
