"""The page of a study of the coupon alone, and its figures."""

from pidpanel.provenance.job import Job, run
from pidpanel.report.from_study import write_coupon_page


def main(job: Job) -> None:
    """From the cases and the film of the coupon."""
    made = job.output
    write_coupon_page(job.study, job.input.cases, made.page, made.figures)


if __name__ == "__main__":
    run(main)
