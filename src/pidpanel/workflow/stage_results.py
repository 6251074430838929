"""Results of the stages of a study for notebooks: of a run, or computed when first needed."""

from __future__ import annotations

import contextlib
import io
import tempfile
from collections.abc import Mapping
from pathlib import Path

from pidpanel.arrays import Array
from pidpanel.base.from_study import write_base
from pidpanel.energy.from_study import write_energy
from pidpanel.optimise.from_study import write_proposal
from pidpanel.panel.files import read_basis
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.files import Files, stage_files
from pidpanel.provenance.results import read_netcdf
from pidpanel.response.from_study import write_response
from pidpanel.sound.from_study import write_sound
from pidpanel.structure.from_study import write_panel
from pidpanel.study import Study, StudyError

# Stages whose results a stage reads.
UPSTREAM = {
    "panel": (), "sound": ("panel",), "base": ("panel",), "response": ("panel", "sound"),
    "optimise": ("panel", "sound"), "energy": ("panel", "sound", "response"),
}  # fmt: skip


class ResultsError(RuntimeError):
    """Results that are not there, or not those of the study."""


def result_at(path: Path) -> Path:
    """Return the path of a result; `ResultsError` where there is none."""
    if not path.exists():
        raise ResultsError(f"{path}: missing; it needs LIGGGHTS runs: call run() first")
    return path


class StageResults:
    """Files of the stages of a study: those of a run if it is simulated, else computed here."""

    def __init__(self, study: Study, results: Path) -> None:
        self.study, self.results = study, results
        self._is_simulated = bool(study.coupons) or study.is_coupled
        self._folder = tempfile.TemporaryDirectory(prefix="pidpanel_")
        self._computed: set[str] = set()  # stages

    @property
    def has_response(self) -> bool:
        """Whether the responses are computed."""
        return "response" in self._computed

    def files(self, stage: str, lines: Array | None = None) -> Files:
        """Return the files of a stage; those of the responses on given lines (nf,) [Hz]."""
        folder = Path(self._folder.name)
        stages = stage_files(self.study, self.results if self._is_simulated else folder)
        if stage not in stages:
            section = "sound" if stage == "response" else stage
            raise StudyError(f"{self.study.name}: {section}: missing; {stage} needs it")
        if self._is_simulated:
            self._check_run(stages, stage)
        elif stage not in self._computed and lines is None:
            self._compute(stage, stages[stage])
        if lines is None:
            self._computed.add(stage)
            return stages[stage]
        files = stage_files(self.study, folder / "lines")[stage]
        self._compute(stage, files, lines)
        return files

    def _check_run(self, stages: Mapping[str, Files], stage: str) -> None:
        """Refuse results of a run that are missing or not those of the study."""
        responses = stages["response" if "response" in stages else "base"]
        curves = next(p for (p,) in responses.all.values() if p.suffix == ".nc")
        for path in (curves, *(path for (path,) in stages[stage].all.values())):
            result_at(path)
        if read_netcdf(curves).attrs.get("study_hash") != stamp(self.study)["study_hash"]:
            raise ResultsError(f"{curves}: of another state of the study; call run() again")

    def _compute(self, stage: str, files: Files, lines: Array | None = None) -> None:
        """Compute a stage after those whose results it reads."""
        study, upstream = self.study, Files({})
        for name in UPSTREAM[stage]:
            if name != "sound" or study.sound is not None:
                upstream = Files({**upstream.all, **self.files(name).all})
        for (path,) in files.all.values():
            path.parent.mkdir(parents=True, exist_ok=True)
        with contextlib.redirect_stderr(io.StringIO()):  # lines for the log of the stage
            if stage == "panel":
                write_panel(study, files)
            elif stage == "sound":
                write_sound(study, read_basis(upstream.modes), files)
            elif stage == "base":
                write_base(study, upstream, None, files)
            elif stage == "optimise":
                write_proposal(study, upstream, None, files)
            elif stage == "energy":
                write_energy(study, upstream, files, *self._folders)
            else:
                write_response(study, upstream, files, *self._folders, lines)

    @property
    def _folders(self) -> tuple[Path | None, Path | None]:
        """Folders of the surfaces and of the coupled runs; None for a study without any."""
        damping = self.results / "damping" if self.study.coupons else None
        return damping, self.results / "coupled" if self.study.is_coupled else None
