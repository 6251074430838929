"""How long what a study would run takes."""

from pathlib import Path

from pidpanel.cli.study_overview import all_cases, coupled_count, other_stages
from pidpanel.coupon.estimate import PLAN, USUAL_COSTS, cpu_seconds
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
    coupled = [_of_coupled(study)] if isinstance(study, Study) and study.is_coupled else []
    if left:
        seconds = PLAN + cpu_seconds(left, USUAL_COSTS, folder)
        parts = [
            f"{len(left)} of {len(cases)} coupon cases to run, about {seconds / 60:.1f} min of CPU "
            f"time, {seconds / jobs / 3600:.2f} h on {jobs} free cores"
        ]
    elif coupled:
        parts = [f"{len(cases)} coupon cases are complete"] if cases else []
    else:
        parts = [f"no LIGGGHTS runs left, {len(cases)} coupon cases are complete"]
    return f"{study.name}: {'; '.join([*parts, *coupled])}"


def _of_coupled(study: Study) -> str:
    """Return in how many scenarios panel and particles are together, and how long that takes."""
    # two seconds of imports that other studies do not need
    from pidpanel.coupled.from_study import estimated_cpu_seconds

    count, minutes = coupled_count(study), estimated_cpu_seconds(study) / 60
    return (
        f"panel and particles together in {count} scenarios, {minutes:.0f} min of CPU time or more"
    )
