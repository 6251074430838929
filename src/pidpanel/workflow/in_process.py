"""A study without LIGGGHTS in one process, from panel to page: all of it is computed, or nothing.

Snakemake takes seconds before its first job, and each of its jobs imports the same libraries. Two
calls share only the digest of study and package: if it is the same and the files are as they were
left, the second call does nothing. Snakemake treats these files as incomplete.
"""

import fcntl
import json
import os
import shutil
import sys
import time
from base64 import urlsafe_b64encode
from collections.abc import Callable, Iterator
from contextlib import contextmanager, redirect_stderr
from pathlib import Path
from typing import TextIO, TypeGuard

from pidpanel.job import keep_memory, one_line
from pidpanel.progress import CORES, map_in_forks
from pidpanel.provenance.digests import package_digest, text_digest, values_digest
from pidpanel.provenance.files import Files, stage_files
from pidpanel.study import CouponStudy, Study

RECORD = ".in_process.json"  # in ``results/<study>``: a digest, and the files that were left
LOG = "run.log"  # output of the stages
SNAKEMAKE = Path(".snakemake") / "incomplete"


class StageFailed(RuntimeError):
    """A stage that failed, or a study that another process computes."""


def is_alone(study: CouponStudy) -> TypeGuard[Study]:
    """Return whether a study can be computed without LIGGGHTS."""
    return isinstance(study, Study) and not (study.coupons or study.is_coupled)


def is_up_to_date(study: Study, folder: Path) -> bool:
    """Return whether the results below a folder are those that `compute` left of this study."""
    results = folder / "results" / study.name
    try:
        record = json.loads((results / RECORD).read_bytes())
        files = record["files"]
        return bool(record["digest"] == _digest(study) and files and files == _left(study, results))
    except (OSError, ValueError, KeyError, TypeError):
        return False


def compute(study: Study, file: Path, folder: Path, jobs: int) -> None:
    """Compute a study without LIGGGHTS into ``results/<study>`` of a folder.

    Parameters
    ----------
    file
        File of the study, which its page names.
    jobs
        Number of processes of stages that need not wait for each other, and of parts of a stage.

    Raises
    ------
    StageFailed
        If a stage fails, or another process computes the study.
    """
    results = folder / "results" / study.name
    results.mkdir(parents=True, exist_ok=True)
    (results / LOG).touch()
    with (results / LOG).open("r+", encoding="utf-8", buffering=1) as log:
        try:
            fcntl.flock(log, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise StageFailed(f"{results}: another process runs the study here") from None
        log.truncate()
        stages = stage_files(study, results)
        _begin(stages, folder)
        os.environ[CORES] = str(jobs)
        keep_memory()
        _compute(study, file, results, stages, log)
    record = {"digest": _digest(study), "files": _left(study, results)}
    (results / RECORD).write_text(json.dumps(record), encoding="utf-8")


def _begin(stages: dict[str, Files], folder: Path) -> None:
    """Remove what an earlier run left, so that none of it is taken for a result of this one."""
    longest = os.pathconf(folder, "PC_NAME_MAX") - 1
    for path in _paths(stages):
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink(missing_ok=True)
        path.parent.mkdir(parents=True, exist_ok=True)
        # the mark that Snakemake itself gives to the files of a job until it has ended
        name = urlsafe_b64encode(str(path.relative_to(folder)).encode()).decode()
        *parts, last = [name[k : k + longest] for k in range(0, len(name), longest)]
        mark = folder.joinpath(SNAKEMAKE, *(f"@{part}" for part in parts), last)
        mark.parent.mkdir(parents=True, exist_ok=True)
        mark.write_text('{"external_jobid": null}', encoding="utf-8")


def _compute(
    study: Study, file: Path, results: Path, stages: dict[str, Files], log: TextIO
) -> None:
    from pidpanel.panel.files import read_basis
    from pidpanel.report.from_study import write_study_page
    from pidpanel.structure.from_study import write_panel

    panel = stages["panel"]
    with _stage("panel", log):
        write_panel(study, panel)
    upstream = Files(panel.all)
    if study.sound is not None:
        from pidpanel.response.from_study import write_response
        from pidpanel.sound.from_study import write_sound

        with _stage("sound", log):
            write_sound(study, read_basis(panel.modes), stages["sound"])
        upstream = Files(upstream.all | stages["sound"].all)
        with _stage("response", log):
            write_response(study, upstream, stages["response"], None, None)
    branches = list(_branches(study, upstream, stages, log))
    for _ in map_in_forks(lambda k: branches[k](), range(len(branches))):
        pass
    with _stage("report", log):
        write_study_page(study, file, results, stages["report"].page, stages["report"].figures)


def _branches(
    study: Study, upstream: Files, stages: dict[str, Files], log: TextIO
) -> Iterator[Callable[[], None]]:
    """Yield what can be computed at the same time, each with what needs its results."""
    everything = Files(upstream.all | stages["response"].all) if study.sound else upstream

    def maps() -> None:
        from pidpanel.response.from_study import write_maps

        with _stage("maps", log):
            write_maps(study, everything, stages["maps"])
        if study.severity is not None:
            from pidpanel.severity.from_study import write_severity

            with _stage("severity", log):
                read = Files(everything.all | {"maps": stages["maps"].several("maps")})
                write_severity(study, read, stages["severity"])

    def energy() -> None:
        from pidpanel.energy.from_study import write_energy

        with _stage("energy", log):
            write_energy(study, everything, stages["energy"], None, None)

    def export() -> None:
        from pidpanel.response.from_study import write_export

        with _stage("export", log):
            folder = stages["export"].folder
            write_export(study, everything.modes, everything.psd, everything.summary, folder)

    def base() -> None:
        shaken = stages.get("base", Files({}))
        if study.base is not None:
            from pidpanel.base.from_study import write_base, write_base_export

            with _stage("base", log):
                write_base(study, upstream, None, shaken)
            if study.base.random is not None:
                with _stage("base_export", log):
                    folder = stages["base_export"].folder
                    write_base_export(study, upstream.modes, shaken.psd, shaken.summary, folder)
        _compare(study, everything, stages, log)

    def optimise() -> None:
        from pidpanel.optimise.from_study import write_proposal

        with _stage("optimise", log):
            write_proposal(study, upstream, None, stages["optimise"])

    def margin() -> None:
        from pidpanel.margin.from_study import write_margin

        with _stage("margin", log):
            write_margin(study, None, stages["margin"])

    if study.optimise is not None:
        yield optimise
    if study.uncertain:
        yield margin
    if study.sound is not None:
        yield maps
        yield export
    if study.energy is not None:
        yield energy
    yield base


def _compare(study: Study, everything: Files, stages: dict[str, Files], log: TextIO) -> None:
    """Compare the responses with limits and measurements."""
    shaken = stages.get("base", Files({}))
    if study.limits:
        from pidpanel.severity.from_study import write_margins

        with _stage("margins", log):
            moved = {f"base_{key}": shaken.several(key) for key in ("psd", "summary")}
            write_margins(study, Files(everything.all | moved), stages["margins"].margins)
    if study.measurements:
        from pidpanel.measurement.from_study import write_measurements

        with _stage("measurement", log):
            motion = shaken.get("psd") or shaken.get("sine")
            curves, output = {"sound": everything.get("psd"), "base": motion}, stages["measurement"]
            tables = output.measured, output.differences
            write_measurements(study, curves, *tables, everything, output.get("hammer"))


@contextmanager
def _stage(name: str, log: TextIO) -> Iterator[None]:
    """Write the output of a stage to the log; name it in a failure that has a line."""
    begun = time.monotonic()
    try:
        with redirect_stderr(log):
            yield
    except Exception as error:
        message = one_line(error)
        if message is None or isinstance(error, OSError | StageFailed):
            raise
        raise StageFailed(f"{name}: {message}") from None
    print(f"{name}, {time.monotonic() - begun:.0f} s", file=sys.stderr, flush=True)


def _digest(study: Study) -> str:
    return text_digest([values_digest(study.model_dump()), package_digest()])


def _paths(stages: dict[str, Files]) -> list[Path]:
    return [path for files in stages.values() for paths in files.all.values() for path in paths]


def _left(study: Study, results: Path) -> dict[str, list[int]]:
    """Return size and time of each file of the study; none if one is missing."""
    paths = _paths(stage_files(study, results))
    if not all(path.exists() for path in paths):
        return {}
    files = [file for path in paths for file in ([path] if path.is_file() else path.rglob("*"))]
    stats = {str(file.relative_to(results)): file.stat() for file in files}
    return {name: [stat.st_size, stat.st_mtime_ns] for name, stat in sorted(stats.items())}
