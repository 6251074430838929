import atexit
import functools
import logging
import itertools
import json
import os
import shutil
import sys
import tempfile
from pathlib import Path

import snakemake.persistence.file
from snakemake.exceptions import WorkflowError
from snakemake.logging import logger
from snakemake.utils import listfiles

from pidpanel import durable, made
from pidpanel.check import check_machine, checked_study
from pidpanel.coupon import finished
from pidpanel.coupon.batches import Batch, batches_of, parts_of
from pidpanel.coupon.estimate import run_memory
from pidpanel.coupon.from_study import cases_at, cases_by_coupon, distinct
from pidpanel.coupon.liggghts.deck import without_comments
from pidpanel.coupon.older import describe_older
from pidpanel.fingerprint import code_digest, file_digest, text_digest
from pidpanel.locks import take_stale
from pidpanel.owner import OwnerError, check_owner, write_owner
from pidpanel.paths import PACKAGE, PAPER_TABLE, SECTION, TEMPLATES, WORKFLOW
from pidpanel.paths import in_a_path, of_damper, study_path
from pidpanel.coupon.round import Round
from pidpanel.stamp import by_content
from pidpanel.study import Study, StudyError
from pidpanel.study.study import NAME

# the study is the configuration, or the file that its key `study` names (config/README.md)
if "study" in config or not workflow.configfiles:
    STUDY_FILE = str(study_path(str(config.get("study", "paper.yaml"))).resolve())
else:
    STUDY_FILE = str(Path(workflow.configfiles[-1]).resolve())
# longest time of a job [s], of a cluster's profile; without it, each case is run in one go
JOB_SECONDS = 60 * float(config.get("job_minutes", "inf"))
# a job that is not done when its time is over is tried again and goes on from its last restart
TRIED_AGAIN = 50 if JOB_SECONDS < float("inf") else None
# what all else waits for
FIRST = 10**6
# Snakemake finds its locks with a pattern, in which braces of the working folder are wildcards
snakemake.persistence.file.listfiles = lambda pattern: listfiles(os.path.relpath(pattern))
# the scripts run as `python -m scripts.<name>`, under the Python that runs Snakemake, and import
# nothing from the working folder; they are many and short, so what they import is compiled once
os.environ.pop("PYTHONDONTWRITEBYTECODE", None)
os.environ.update(
    PATH=f"{Path(sys.executable).parent}:{os.environ.get('PATH', '')}",
    PYTHONPATH=f"{WORKFLOW}:{PACKAGE.parent}",
    PYTHONSAFEPATH="1",
    OMP_NUM_THREADS="1",
    # no params: where the study lies and how long a job may be change no result
    PIDPANEL_STUDY=STUDY_FILE,
    # what it has started ends with it
    PIDPANEL_WORKFLOW_PROCESS=str(os.getpid()),
    PIDPANEL_JOB_SECONDS=str(JOB_SECONDS),
)


def read_study():
    """The study, or one line that says what is wrong with it or with the machine."""
    try:
        study = checked_study(STUDY_FILE)
        check_machine(study, Path("results"))
        check_owner(study, Path(STUDY_FILE), Path("results"))
    except (StudyError, OwnerError) as error:
        raise WorkflowError(str(error)) from None
    return study


STUDY = read_study()
# a log that cannot be written is no reason for a traceback; the error itself is told
logging.raiseExceptions = False
HAS_PANEL = isinstance(STUDY, Study)
# with a target or with tones, rounds choose cases (design.smk)
HAS_TARGET = HAS_PANEL and STUDY.damping.target is not None
HAS_ROUNDS = HAS_PANEL and (HAS_TARGET or STUDY.damping.tones is not None)

PAGE_FILES = sorted(path for path in (TEMPLATES / "report").rglob("*") if path.is_file())


def results(name):
    """A file of this study."""
    return f"results/{STUDY.name}/{name}"


def section(*names, without=None):
    """Hash of sections of the study, or of all, with the files that they name by their content.

    What rests on them runs again when they change. A hash, since Snakemake takes braces in a text
    for wildcards.
    """
    return values_digest(STUDY.model_dump(include=set(names) or None, exclude=without))


def values_digest(values):
    """Hash of values of the study; files by their content."""
    return text_digest([json.dumps(by_content(values), sort_keys=True)])


def coupon_file(stage, damper, name):
    """A file of one coupon of this study."""
    return str(of_damper(Path(results(stage)), damper, name))


def coupon_digest(damper):
    """Hash of one coupon: what rests on another does not run again when it changes."""
    return values_digest(STUDY.coupons[damper].model_dump())


def code(script):
    """Hash of a script and of all that it imports here, comments left out, once it is asked for.

    What a script made runs again when this changes. Asked for only where there is such a job: to
    read all code takes seconds.
    """
    return lambda wildcards: digest_of_code(f"scripts.{script}")


digest_of_code = functools.cache(code_digest)


def content(*paths):
    """Hash of files that come with pidpanel: what rests on them runs again when it changes.

    No inputs of the rules: where the project lies changes no result.
    """
    return file_digest(*(Path(path) for path in paths))


def commands(*names):
    """Hash of templates of decks without comments: a comment costs no run of LIGGGHTS."""
    texts = ((TEMPLATES / name).read_text(encoding="utf-8") for name in names)
    return text_digest(without_comments(text) for text in texts)


def job_minutes(cost, attempt):
    """Time that a job is given on a cluster [min], longer where it was not enough."""
    return int(attempt * (5 + min(JOB_SECONDS, 2 * cost) / 60))


def memory_of(runs):
    """Memory that a process with one of some runs at a time takes [MB]."""
    return max(int(run_memory(run) / 1e6) for run in runs)


def part_of(wildcards):
    """The part of a long case that a leg is of."""
    return parts_of(CASES[wildcards.case], JOB_SECONDS)[int(wildcards.part)]


def beds_of_part(wildcards):
    """The beds of the runs of a part of a long case."""
    runs = [CASES[wildcards.case].runs[number] for number in part_of(wildcards).runs]
    return [f"results/coupon/bed/{run.bed.label}/bed.json" for run in runs]


def leg_of_part_before(wildcards):
    """The leg before of the same runs; nothing before the first."""
    name, leg = f"results/coupon/leg/{wildcards.case}/{wildcards.part}", int(wildcards.leg)
    return [f"{name}_{leg - 1}.json"] if leg else []


def cost_left(wildcards):
    """CPU time that a leg and those after it take: the longest go first."""
    return max(0, int(part_of(wildcards).cost - int(wildcards.leg) * JOB_SECONDS))


def last_legs(batch):
    """The last leg of every part of a batch, where it is one long case."""
    return [
        f"results/coupon/leg/{case.label}/{number}_{part.legs - 1}.json"
        for case in batch.cases
        for number, part in enumerate(parts_of(case, JOB_SECONDS))
    ]


def beds_of(batch):
    """The beds from which the runs of a batch start."""
    labels = dict.fromkeys(run.bed.label for case in batch.cases for run in case.runs)
    return [f"results/coupon/bed/{label}/bed.json" for label in labels]


def outcomes_of(labels, table):
    """What the batches of some cases leave; a batch that lacks the outcome of a run runs again.

    ``table`` is the one that is made of them.
    """
    found = []
    for label in dict.fromkeys(BATCH_OF[label] for label in labels):
        file = f"results/coupon/batch/{label}.json"
        found.append(file)
        if file in LOOKED_AT or not workflow.is_main_process:
            continue
        LOOKED_AT[file] = file
        if Path(file).exists() or Path(table).exists():
            # Snakemake knows one file per batch, not the outcomes behind it, and makes no file again
            # from which a table was made that is still there
            anew, faults = finished.changes(BATCHES[label], Path("results/coupon"), SHAKE(None))
            for fault in faults:
                logger.warning(fault)
            if anew:
                workflow.dag.forcefiles.add(file)
    return found


# what is found of the files of a job is found once: on its way it changes them itself
LOOKED_AT = {}
DRAFTS = Path(tempfile.mkdtemp(prefix="pidpanel_"))
atexit.register(shutil.rmtree, DRAFTS, ignore_errors=True)


@functools.cache
def will_run():
    """Whether jobs will be run, not only listed or drawn; then nobody else holds a stale lock."""
    runs = workflow.is_main_process and workflow.executor_plugin and not workflow.dryrun
    if runs:
        # held as long as this process lives
        workflow.pidpanel_lock, taken = take_stale(Path("results"), Path(".snakemake/locks"))
        if taken:
            logger.warning(f"{taken[0].parent}: left by a process that was killed; taken over")
        write_owner(STUDY, Path(STUDY_FILE), Path("results"))
        if left_over := describe_older(Path("results/coupon"), {*CASES, *BEDS, *PACKINGS}):
            logger.warning(left_over)
    return bool(runs)


def rests(*outputs, **values):
    """What the files of a rule rest on besides its other inputs, in a file below ``results``.

    A job is done again when the values change, and when what it left is damaged or lost; nothing of
    this hangs on ``.snakemake``. Values may be functions of the wildcards.
    """

    def file_of(wildcards):
        runs = will_run()
        made_files = [output.format(**dict(wildcards.items())) for output in outputs]
        file = made.rests_file(made_files[0])
        if workflow.is_main_process and file not in LOOKED_AT:
            texts = {key: v(wildcards) if callable(v) else v for key, v in values.items()}
            # who only looks leaves the results as they are
            wanted = file if runs else DRAFTS / f"{len(LOOKED_AT)}{made.RESTS}"
            made.write_rests(wanted, texts)
            LOOKED_AT[file] = file if file.exists() else wanted
            anew, damaged = made.changes(file, made_files, wanted)
            for path in damaged:
                why = f"{path}: damaged, changed or lost since it was made"
                durable.set_aside(path, why) if runs else logger.warning(why)
            if anew:
                workflow.dag.forcefiles.update(made_files)
        return str(LOOKED_AT.get(file, file))

    # newer or older says nothing: its content counts
    return ancient(file_of)


def outcomes_wanted(damper):
    """What the cases of a coupon leave: all of its sweep, or those that the rounds wanted."""
    chosen = COUPON_CASES[damper]
    if HAS_ROUNDS and damper == SECTION:
        chosen = cases_of_round(last_round())
    return outcomes_of(chosen, coupon_file("coupon", damper, "cases.csv"))


def cases_of_round(file):
    """Labels of the cases of a round; its tones are in no sweep, and are made known here."""
    chosen = Round.read(Path(file))
    tones = cases_at(STUDY.coupon, chosen.tones)
    for case in tones:
        if case.label not in BATCH_OF:
            add_batch(Batch((case,)))
    return [*chosen.cases, *(case.label for case in tones)]


def last_round():
    """The round that wants no more cases."""
    number = 0
    while True:
        found = checkpoints.design.get(round=number).output[0]
        if Round.read(Path(found)).is_last:
            return found
        number += 1


def round_before(wildcards):
    """The round before, and its cases."""
    number = int(wildcards.round) - 1
    names = (f"design/round{number}.json", f"design/cases{number}.csv")
    return [results(name) for name in names] if number >= 0 else []


def outcomes_of_round(wildcards):
    """What the cases of a round leave."""
    found = checkpoints.design.get(round=wildcards.round).output[0]
    return outcomes_of(cases_of_round(found), results("coupon/cases.csv"))


# batches, beds and packings by their labels, filled in coupon.smk and as rounds want more
BATCHES, BATCH_OF = {}, {}
BEDS, PACKINGS = {}, {}


def add_batch(batch):
    """Make a batch known, and its beds and packings."""
    BATCHES[batch.label] = batch
    for case in batch.cases:
        BATCH_OF[case.label] = batch.label
        for run in case.runs:
            BEDS[run.bed.label] = run.bed
            PACKINGS[run.packing.label] = run.packing


def coupled_digest(label):
    """Hash of what the study says of the runs of a scenario beside its panel."""
    coupled = COUPLED_SCENARIOS[label]
    dampers = {filling.damper for filling in coupled.scenario.fillings}
    unused = {"coupon": {"sweep", "accuracy"}}
    response = {"frequency_hz", "damper_mass", "radiation", "air_mass"}
    return values_digest(
        {
            "scenario": coupled.scenario.model_dump(),
            "coupled": STUDY.damping.coupled.model_dump(exclude={"scenarios"}),
            "dampers": [
                STUDY.all_dampers[name].model_dump(exclude=unused) for name in sorted(dampers)
            ],
            "damping_ratio": STUDY.panel.damping_ratio,
            "sound": STUDY.sound.model_dump(),
            "response": STUDY.response.model_dump(include=response),
        }
    )
