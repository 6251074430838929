import hashlib
import json
import os
import sys
from pathlib import Path

from snakemake.exceptions import WorkflowError

from pidpanel.check import check_machine, checked_study
from pidpanel.coupon.batches import Batch, batches_of
from pidpanel.coupon.cases import cases_of
from pidpanel.study import Study, StudyError

PROJECT = Path(workflow.basedir)
STUDY_FILE = str(
    Path(workflow.configfiles[-1]).resolve()
    if workflow.configfiles
    else PROJECT / "workflow/studies/paper.yaml"
)
# the adapters run as `python -m scripts.<name>`, under the Python that runs Snakemake; they are
# many and short, so what they import is compiled once
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
os.environ.update(
    PATH=f"{Path(sys.executable).parent}:{os.environ.get('PATH', '')}",
    PYTHONPATH=str(PROJECT / "workflow"),
    OMP_NUM_THREADS="1",
)


def read_study():
    """The study, or one line that says what is wrong with it or with the machine."""
    try:
        study = checked_study(STUDY_FILE)
        check_machine(study, Path("results"))
    except StudyError as error:
        raise WorkflowError(str(error)) from None
    return study


STUDY = read_study()
CASES = {case.label: case for case in cases_of(STUDY.coupon)} if STUDY.coupon else {}
HAS_PANEL = isinstance(STUDY, Study)
BEDS = {run.bed.label: run.bed for case in CASES.values() for run in case.runs}
PACKINGS = {bed.packing.label: bed.packing for bed in BEDS.values()}
# a design chooses case by case
CHOOSES = HAS_PANEL and STUDY.damping.target is not None
BATCHES = {
    batch.label: batch
    for batch in (
        [Batch((case,)) for case in CASES.values()] if CHOOSES else batches_of(CASES.values())
    )
}
# a batch of which a run was taken away by hand is shaken again
for label, batch in BATCHES.items():
    marker = Path("results/coupon/batch", f"{label}.json")
    left = (path for case in batch.cases for path in case.outcomes(Path("results/coupon")))
    if marker.exists() and not all(path.exists() for path in left):
        marker.unlink()
BATCH_OF = {case.label: label for label, batch in BATCHES.items() for case in batch.cases}


def beds_of(batch):
    """The beds from which the runs of a batch start."""
    labels = dict.fromkeys(run.bed.label for case in batch.cases for run in case.runs)
    return [f"results/coupon/bed/{label}/bed.json" for label in labels]


def outcomes_of(labels):
    """What the batches of some cases leave."""
    batches = dict.fromkeys(BATCH_OF[label] for label in labels)
    return [f"results/coupon/batch/{label}.json" for label in batches]


def last_round():
    """The round of the design that wants no more cases; None for a study without a target."""
    if not CHOOSES:
        return None
    number = 0
    while True:
        found = checkpoints.design.get(round=number).output[0]
        if json.loads(Path(found).read_text())["new"] == 0:
            return found
        number += 1


def outcomes_wanted(wildcards):
    """What the cases of the study leave: all of the sweep, or those its target needed."""
    chosen = last_round()
    return outcomes_of(json.loads(Path(chosen).read_text())["cases"] if chosen else CASES)


def round_before(wildcards):
    """The round before, and its cases."""
    number = int(wildcards.round) - 1
    names = (f"design/round{number}.json", f"design/cases{number}.csv")
    return [results(name) for name in names] if number >= 0 else []


def outcomes_of_round(wildcards):
    """What the cases of a round leave."""
    found = checkpoints.design.get(round=wildcards.round).output[0]
    return outcomes_of(json.loads(Path(found).read_text())["cases"])


def results(name):
    """A file of this study."""
    return f"results/{STUDY.name}/{name}"


def section(*names):
    """Sections of the study as text: what rests on them runs again when they change."""
    return json.dumps({name: STUDY.model_dump(mode="json")[name] for name in names}, sort_keys=True)


def code(*names):
    """Hash of the modules of a stage: what rests on them runs again when they change."""
    digest = hashlib.sha256()
    for name in names:
        path = PROJECT / "src" / "pidpanel" / name
        for file in sorted(path.rglob("*.py")) if path.is_dir() else [path]:
            digest.update(file.read_bytes())
    return digest.hexdigest()
