# The study, and what all rules share. What decides is in the package, `pidpanel.workflow`.

from pathlib import Path

from pidpanel.paths import SECTION, in_a_path
from pidpanel.provenance.digests import values_digest
from pidpanel.provenance.job import arguments_of
from pidpanel.provenance.links import LinkError, check_working_folder
from pidpanel.provenance.owner import OwnerError
from pidpanel.study import StudyError
from pidpanel.study.coupon_study import NAME
from pidpanel.workflow.plan import Plan, WorkflowRunning, bed_files, has_study
from pidpanel.workflow.rules import (
    RESPONSE_SECTIONS,
    air_files,
    coupled_files,
    films,
    panel_rules,
    scenarios_digest,
)
from snakemake.exceptions import WorkflowError

if not has_study(config) and Path("config/config.yaml").exists():

    configfile: "config/config.yaml"


def planned():
    """The plan, or one line that says what is wrong with the study or with the machine."""
    try:
        if workflow.is_main_process:
            check_working_folder(Path("."))
        return Plan.read(config, workflow.configfiles)
    except (StudyError, OwnerError, LinkError) as error:
        raise WorkflowError(str(error)) from None


PLAN = planned()
STUDY, RUNS = PLAN.study, PLAN.runs
results, section, damper_file = PLAN.results, PLAN.section, PLAN.damper_file
FILMS = films(PLAN)
# rules that `pidpanel run` also runs by itself, where a study has no LIGGGHTS runs
RULES = panel_rules(PLAN, STUDY) if PLAN.has_panel else {}
if PLAN.has_panel:
    PANEL, SCENARIOS = RULES["panel"].output, scenarios_digest(STUDY)
    if STUDY.sound is not None:
        FORCE, AIR = RULES["sound"].output["modal_force"], air_files(RULES["sound"])
    else:
        FORCE, AIR = [], []


wildcard_constraints:
    batch="[^/]+",
    bed="[^/]+",
    damper=NAME,
    leg=r"\d+",
    packing="[^/]+",
    part=r"\d+",
    scenario="[^/]+",


onstart:
    try:
        PLAN.begin()
    except WorkflowRunning as error:
        raise WorkflowError(str(error)) from None


def request(*outputs, **values):
    """The request of a job: what its files depend on besides other results and the package.

    Values may be functions of the wildcards.
    """

    def file_of(wildcards):
        texts = {key: v(wildcards) if callable(v) else v for key, v in values.items()}
        files = [output.format(**dict(wildcards.items())) for output in outputs]
        return PLAN.requests.quick(files, texts)

    return file_of


def request_of(name):
    """The request of a rule of the panel."""
    return lambda wildcards: PLAN.request(RULES[name])


def job(**params):
    """The named files of a job and further texts, as `pidpanel.provenance.job` reads them.

    Texts may be functions of the wildcards.
    """

    def arguments(wildcards, input, output):
        texts = {key: v(wildcards) if callable(v) else v for key, v in params.items()}
        files = {"input": dict(input.items()), "output": dict(output.items())}
        return arguments_of(**files, params=texts)

    return arguments
