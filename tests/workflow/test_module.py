"""The workflow as a module of another one, as the workflow catalogue deploys it."""

import subprocess
import sys
from pathlib import Path

import yaml

from tests.workflow.test_workflow import ROOT, said

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
    snakemake = Path(sys.executable).with_name("snakemake")
    result = subprocess.run(
        [snakemake, "-n", "-d", folder, *options], capture_output=True, text=True, check=False
    )
    assert result.returncode == 0, said(result)
    return said(result)


def test_another_workflow_takes_all_rules_for_the_study_that_it_names(tmp_path):
    # red: STUDY_FILE from workflow.configfiles first; a study that comes with pidpanel not found
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
    # red: any of the files left out
    usage = yaml.safe_load((ROOT / ".snakemake-workflow-catalog.yml").read_text())["usage"]
    assert usage["software-stack-deployment"]["apptainer"] is True and usage["report"] is True
    for name in ("workflow/Snakefile", "config/README.md", "config/config.yaml", "LICENSE"):
        assert (ROOT / name).is_file(), name
    assert 'include: "workflow/Snakefile"' in (ROOT / "Snakefile").read_text()
