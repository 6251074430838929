"""How long what a study would run takes."""

from __future__ import annotations

from pathlib import Path

from pidpanel.coupon.estimate import PLAN, cpu_seconds, random_seconds
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.probe import probe
from pidpanel.overview import all_cases, other_stages
from pidpanel.response.random_rounds import expected_legs
from pidpanel.study import CouponStudy, Study


def estimate(study: CouponStudy, results: Path, jobs: int) -> str:
    """Return how many cases of a study are still to be run, and how long each stage takes."""
    runs = _of_runs(study, results, jobs)
    if not isinstance(study, Study):
        return runs
    return f"{runs}\n{study.name}: about this CPU time and memory: {other_stages(study)}"


def _of_runs(study: CouponStudy, results: Path, jobs: int) -> str:
    """Return how many LIGGGHTS runs are left, and how long they take."""
    folder = results / "coupon"
    cases = all_cases(study)
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
    seconds = PLAN + cpu_seconds(left, costs, folder)
    seconds += random_seconds(legs, rounds, costs, folder)
    driven = f" and {len(legs)} packings to drive at random, in {rounds} rounds" if legs else ""
    return (
        f"{study.name}: {len(left)} of {len(cases)} coupon cases to run{driven}, about "
        f"{seconds / 60:.1f} min of CPU time, {seconds / jobs / 3600:.2f} h on {jobs} free cores"
        + coupled
    )
