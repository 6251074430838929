"""How long what a study would run takes, in a line."""

from __future__ import annotations

from pathlib import Path

from pidpanel.coupon.cases import Case
from pidpanel.coupon.estimate import cpu_seconds, random_seconds
from pidpanel.coupon.from_study import cases_of, distinct_cases
from pidpanel.coupon.probe import probe
from pidpanel.response.random_rounds import expected_legs
from pidpanel.study import CouponStudy, Study


def _cases(study: CouponStudy) -> list[Case]:
    """Return every case of all coupons of a study once."""
    return [case for cases in distinct_cases(study).values() for case in cases]


def estimate(study: CouponStudy, results: Path, jobs: int) -> str:
    """Return how many cases of a study are still to be run, and how long that takes."""
    folder = results / "coupon"
    cases = _cases(study)
    left = [case for case in cases if not all(path.exists() for path in case.outcomes(folder))]
    coupled = ""
    if isinstance(study, Study) and study.is_coupled:
        # two seconds of imports that other studies do not need
        from pidpanel.coupled.from_study import coupled_runs, estimated_cpu_seconds

        minutes = estimated_cpu_seconds(study) / 60
        coupled = (
            f"; panel and particles together {len(coupled_runs(study))} runs, {minutes:.0f} min of "
            "CPU time or more"
        )
    legs, rounds = expected_legs(study, results)
    if not left and not legs:
        return (
            f"{study.name}: no LIGGGHTS runs left, {len(cases)} coupon cases are complete{coupled}"
        )
    costs = probe(left or cases_of(study.random_coupons()[0][2]))
    seconds = cpu_seconds(left, costs, folder) + random_seconds(legs, rounds, costs, folder)
    driven = f" and {len(legs)} packings to drive at random, in {rounds} rounds" if legs else ""
    return (
        f"{study.name}: {len(left)} of {len(cases)} coupon cases to run{driven}, about "
        f"{seconds / 60:.1f} min of CPU time, {seconds / jobs / 3600:.2f} h on {jobs} free cores"
        + coupled
    )
