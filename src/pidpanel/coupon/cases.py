"""Packings, beds, runs and cases, each with a label by what it depends on.

A label is readable and ends in a hash of everything that its numbers depend on, so studies share
runs by their labels:

packing
    its values and outline, the constants of the pour (`POURING`), the deck that pours, the
    command that runs it, the version of LIGGGHTS, the versions of the algorithms that
    place spheres and pour (`PLACEMENT_VERSION`, `POUR_VERSION`);
bed
    its packing, its fill fraction, the constants of the loosening (`LOOSENING`), the deck that
    shakes it loose, the command that runs it, the version of LIGGGHTS, the version of the algorithm
    that loosens (`LOOSEN_VERSION`);
run
    its bed, its drive, the deck that shakes it, the command that runs a cycle, the version of
    LIGGGHTS;
case
    its runs.

A deck enters as LIGGGHTS takes it, rendered and without comments. Algorithms enter by version
numbers. Those that read rows and average them (`cycles`, `rows`, `window`, `summary`) do not enter.
``docs/reruns.md`` lists what makes what run again.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from pathlib import Path
from typing import Any

from pidpanel.coupon import contact
from pidpanel.coupon.bed import Run
from pidpanel.provenance.digests import json_digest


@dataclass(frozen=True)
class RunTarget:
    """Length of a run. It is not part of a run's identity: a run continues where it stopped."""

    relative_error: float  # of C_e [1]
    min_cycles: int
    max_cycles: int

    @property
    def label(self) -> str:
        """Part of the name of the outcome file of a case."""
        return f"{100 * self.relative_error:.9g}pc_{self.min_cycles}to{self.max_cycles}"

    def as_strict_as(self, reference: RunTarget) -> RunTarget:
        """Return the target that satisfies another too.

        Examples
        --------
        >>> RunTarget(0.05, 12, 400).as_strict_as(RunTarget(0.1, 20, 200))
        RunTarget(relative_error=0.05, min_cycles=20, max_cycles=400)
        """
        return RunTarget(
            min(self.relative_error, reference.relative_error),
            max(self.min_cycles, reference.min_cycles),
            max(self.max_cycles, reference.max_cycles),
        )


@dataclass(frozen=True)
class Case:
    """One point of the sweep: the runs of all its seeds."""

    runs: tuple[Run, ...]
    youngs_modulus: float  # the material's own [Pa]; a run may be softer
    relative_error: float  # required of C_e, all seeds together [1]
    target: RunTarget  # of each run: seeds share the work, so each may be √seeds times as uncertain
    # Keys of ``coupon.vary`` with the values at this point
    varied: Mapping[str, Any] = field(default_factory=dict)
    # Runs of further seeds, for a case whose cells end in several states of motion; see `states`
    reserve: tuple[Run, ...] = ()
    # Cycles that all runs of such a case last at least; 0 where the stroke is too short or too long
    # for several states to be looked for
    state_cycles: int = 0

    @property
    def point(self) -> Run:
        """A run that is the case in all but the seed."""
        return self.runs[0]

    @cached_property
    def label(self) -> str:
        """Folder below ``results/coupon``."""
        first, digest = self.runs[0], json_digest(*(run.identity for run in self.runs))
        return (
            f"r{first.fill_fraction:g}_{first.drive.label}"
            f"_d{first.packing.diameter * 1e3:g}mm_{digest[:8]}"
        )

    def as_strict_as(self, reference: Case) -> Case:
        """Return the case with a target that satisfies that of another, of the same runs, too."""
        target = self.target.as_strict_as(reference.target)
        error = min(self.relative_error, reference.relative_error)
        return replace(self, target=target, relative_error=error)

    @property
    def bias(self) -> float:
        """Relative bias of C_e by softened contacts [1]; see `contact.modulus_bias`."""
        run = self.point
        moduli = (run.constants.youngs_modulus, self.youngs_modulus)
        soft, stiff = (run.contact_time_at(modulus) * run.drive.frequency for modulus in moduli)
        deep, stiff_depth = (run.overlap_at(modulus) for modulus in moduli)
        if run.bed.stroke_per_gap(run.drive) < contact.CROSSING:
            deep = stiff_depth
        factors = run.bed.deepening(run.drive), contact.narrowing(run.fill_fraction)
        return contact.modulus_bias(soft, stiff, deep, stiff_depth, *factors)

    def folders(self, folder: Path) -> list[Path]:
        """Return the folders of the runs below ``results/coupon``, one per seed."""
        return [folder / self.label / f"s{run.packing.seed}" for run in self.runs]

    @property
    def least_cycles(self) -> int:
        """Cycles of a run at least: a third of `state_cycles` where several states are possible."""
        target = self.target
        return max(target.min_cycles, min(target.max_cycles, math.ceil(self.state_cycles / 3)))

    @property
    def with_reserve(self) -> Case:
        """The case with its reserve among its runs, in the folder of the same label."""
        case = replace(self, runs=(*self.runs, *self.reserve), reserve=())
        case.__dict__["label"] = self.label
        return case

    @property
    def outcome(self) -> str:
        """Name of its outcome file, with all that the outcome depends on besides its runs."""
        return self.target.label + (f"_states{self.state_cycles}" if self.state_cycles else "")

    def outcome_file(self, folder: Path) -> Path:
        """Return the outcome file below ``results/coupon``: how each run ended."""
        return folder / self.label / f"{self.outcome}.json"
