# The study, and what all rules share.

import os
import pickle
from pathlib import Path

from pidpanel.check import check_machine
from pidpanel.job import WORKFLOW_PROCESS
from pidpanel.paths import COUPON, SECTION, in_a_path, of_damper
from pidpanel.provenance.digests import by_content
from pidpanel.provenance.links import LinkError, check_working_folder
from pidpanel.study import Study, StudyError
from pidpanel.study.coupon_study import DAMPER_NAME
from pidpanel.workflow.configuration import configured_study, has_study, package_version
from snakemake.exceptions import WorkflowError

if not has_study(config) and Path("config/config.yaml").exists():

    configfile: "config/config.yaml"


try:
    if workflow.is_main_process:
        check_working_folder(Path("."))
    if Path("results").is_file():
        raise StudyError("results: must be a writable folder")
    STUDY, FILE = configured_study(config, workflow.configfiles)
except (StudyError, LinkError) as error:
    raise WorkflowError(str(error)) from None

# what scripts find in `snakemake.config`; `job.started` unpacks the study
config = {**config, "study": pickle.dumps(STUDY), "file": FILE}

# a change of the package runs all again but LIGGGHTS, whose runs have their versions in their names
VERSION = package_version()

# files that the page shows; each stage adds its own
REPORTED = []

# jobs end with this process, however that ends, and nothing is imported from the working folder
os.environ.update({WORKFLOW_PROCESS: str(os.getpid()), "PYTHONSAFEPATH": "1"})
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)


wildcard_constraints:
    bed="[^/]+",
    case="[^/]+",
    damper=DAMPER_NAME,
    packing="[^/]+",
    scenario="[^/]+",


onstart:
    try:
        check_machine(STUDY, Path("results"))
    except StudyError as error:
        raise WorkflowError(str(error)) from None


def results(name):
    """A file of the study."""
    return f"results/{STUDY.name}/{name}"


def damper_file(stage, damper, name):
    """A file of one coupon in the folder of a stage."""
    return str(of_damper(Path(results(stage)), damper, name))


def section(*names, without=None):
    """Sections of the study, or all, as the parameters of a rule: files by their content."""
    return by_content(STUDY.model_dump(include=set(names) or None, exclude=without))


def damper_of(wildcards):
    """The damper of a rule; in a study of the coupon alone, its coupon."""
    return wildcards.get("damper", SECTION)


def coupon(wildcards):
    """The coupon of a damper: no other one runs again when it changes."""
    coupon = STUDY.coupons[damper_of(wildcards)]
    return by_content(coupon.model_dump(exclude={"model", "prior", "like"}))


def scenarios():
    """All scenarios of the study."""
    return [by_content(scenario.model_dump()) for scenario in STUDY.all_scenarios()]


def used_dampers():
    """The dampers of the scenarios; simulated tones come as surfaces."""
    unused = {"sweep", "accuracy", "deck", "deck_values", "stiffness", "like"}
    dampers = {name: STUDY.dampers[name] for name in STUDY.used_dampers}
    return {name: by_content(d.model_dump(exclude=unused)) for name, d in dampers.items()}


# beds and packings by their labels
BEDS, PACKINGS = {}, {}


def add_beds(beds):
    """Make beds known, and their packings."""
    for bed in beds:
        BEDS[bed.label] = bed
        PACKINGS[bed.packing.label] = bed.packing


def outcomes(wildcards):
    """The outcome files of the cases of a damper."""
    return [str(case.outcome_file(COUPON)) for case in SWEPT[damper_of(wildcards)].values()]


# folder of a coupon in that of a stage
DAMPER = "{damper}/" if isinstance(STUDY, Study) else ""
