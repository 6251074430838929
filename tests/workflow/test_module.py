"""The workflow as a module of another one, as the workflow catalogue deploys it."""

import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from tests.commands import call, said
from tests.workflow.test_workflow import ROOT

PARENT = """
configfile: "config/config.yaml"


module pidpanel:
    snakefile:
        "{snakefile}"
    config:
        config


use rule * from pidpanel as pidpanel_*


rule mine:
    default_target: True
    input:
        rules.pidpanel_all.input,
    output:
        "mine.txt",
    shell:
        "touch {{output}}"
"""


def dry_run(folder, *options):
    result = call("-n", "-d", folder, *options)
    assert result.returncode == 0, said(result)
    return said(result)


def test_another_workflow_takes_all_rules_for_the_study_that_it_names(tmp_path):
    (tmp_path / "config").mkdir()
    config = (ROOT / "config" / "config.yaml").read_text()
    (tmp_path / "config" / "config.yaml").write_text(config)
    snakefile = tmp_path / "Snakefile"
    snakefile.write_text(PARENT.format(snakefile=ROOT / "workflow" / "Snakefile"))
    said = dry_run(tmp_path, "-s", snakefile)
    name = Path(yaml.safe_load(config)["study"]).stem
    assert f"results/{name}/report.html" in said
    assert "pidpanel_response" in said and "rule mine" in said


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
