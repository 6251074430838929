"""Which cases one process shakes: cheap ones share what a process costs."""

from __future__ import annotations

import hashlib
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

from pidpanel.coupon.cases import Case
from pidpanel.coupon.estimate import StepCost, run_steps, spheres_in

WORTH = 120.0
"""CPU time of LIGGGHTS for which a process is begun [s]; it costs 0.4 s itself, and Snakemake as
much to look after it."""

MOST_RUNS = 32
"""Most runs of a batch: it goes to its process as one argument, of 128 KiB at the most."""

STEP = StepCost(fixed=15e-6, per_sphere=0.35e-6)
"""Of a 2.5 GHz core: only which cases share a process depends on it, never a result."""


@dataclass(frozen=True)
class Batch:
    """Cases that one process shakes, one after the other."""

    cases: tuple[Case, ...]

    @property
    def label(self) -> str:
        """``<cases>_<hash>``; the hash is that of the labels of the cases and their ends."""
        text = " ".join(f"{case.label}/{case.outcome}" for case in self.cases)
        return f"{len(self.cases)}_{hashlib.sha256(text.encode()).hexdigest()[:8]}"

    def as_list(self) -> list[dict[str, Any]]:
        """Its cases as JSON holds them; `Case.from_dict` is the inverse of each."""
        return [case.as_dict() for case in self.cases]


def expected_cost(case: Case) -> float:
    """CPU time of a case on an ordinary core [s]."""
    return sum(
        run_steps(run, case) * STEP.of(spheres_in(run.packing, run.fill_fraction))
        for run in case.runs
    )


def batches_of(cases: Iterable[Case]) -> Iterator[Batch]:
    """Put neighbours in the sweep together until they are worth a process."""
    together: list[Case] = []
    cost = 0.0
    for case in cases:
        runs = sum(len(other.runs) + len(other.reserve) for other in together)
        own = len(case.runs) + len(case.reserve)
        if together and (cost >= WORTH or runs + own > MOST_RUNS):
            yield Batch(tuple(together))
            together, cost = [], 0.0
        together.append(case)
        cost += expected_cost(case)
    if together:
        yield Batch(tuple(together))
