"""Gather the runs of a coupon: ``cases.csv``."""

from pidpanel.coupon.from_study import write_table
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_any_study


def main(job: Job) -> None:
    """From results/coupon."""
    study, damper = load_any_study(job.study), job.params["damper"]
    write_table(study, damper, job.coupon, job.output.cases)


if __name__ == "__main__":
    run(main)
