"""What integrating panel and particles together requires of a study."""

from __future__ import annotations

from collections.abc import Iterator
from typing import TYPE_CHECKING

from pidpanel.study.damping import COUPLED, NEIGHBOURS_DB
from pidpanel.study.mistakes import Mistake

if TYPE_CHECKING:
    from pidpanel.study.study import Study

# Of a record, 1/T apart, in the range of the response: their scatter is the error of C_e.
FEWEST_LINES = 10

# Of the lowest frequency in a record: both of its halves then resolve a third octave there.
FEWEST_PERIODS = 10


def mistakes_of_coupled(study: Study) -> Iterator[Mistake]:
    """Yield what panel and particles cannot be integrated with."""
    if not study.is_coupled:
        return
    yield from _mistakes_of_lines(study)
    keys = ("damping", "readings")
    if study.response.modal_damping != "full":
        yield Mistake(
            keys, (f"the damping model '{COUPLED}' is only allowed with modal_damping: full")
        )
    if not study.has_filled_coupon:
        says = f"the damping model '{COUPLED}' needs a scenario with a coupon; there is none"
        yield Mistake(keys, says)
    filled = {scenario.label: scenario for scenario in study.coupled_scenarios()}
    run = study.damping.coupled.scenarios or tuple(filled)
    run_keys = ("damping", "coupled", "scenarios")
    for label in run:
        if label not in filled:
            yield Mistake(run_keys, f"unknown scenario {label!r}; allowed are {', '.join(filled)}")
    for label, scenario in filled.items():
        levels = [
            filled[name].oaspl_db
            for name in run
            if name in filled and filled[name].fillings == scenario.fillings
        ]
        if not any(_are_neighbours(scenario.oaspl_db, level) for level in levels):
            says = f"must contain {label}, or its layout within {NEIGHBOURS_DB:g} dB of it"
            yield Mistake(run_keys, says)


def _mistakes_of_lines(study: Study) -> Iterator[Mistake]:
    """Yield records that have too few lines in the range of the response, 1/T apart."""
    low, high = study.response.frequency_hz
    shortest = max(FEWEST_LINES / (high - low), FEWEST_PERIODS / low)
    if study.damping.coupled.duration_s < shortest:
        says = f"must be at least {shortest:.3g} for response.frequency_hz = [{low:g}, {high:g}]"
        yield Mistake(("damping", "coupled", "duration_s"), says)


def _are_neighbours(first: float | None, second: float | None) -> bool:
    """Whether what is found at a level may be carried to another; None is that of the spectrum."""
    return first is None or second is None or abs(first - second) <= NEIGHBOURS_DB + 1e-9
