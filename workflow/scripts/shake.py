"""Shake the cases of a batch: a folder for each run, and how each ended."""

from pidpanel.coupon import attempts
from pidpanel.coupon.batches import read_cases
from pidpanel.coupon.runs import time_limit
from pidpanel.provenance.job import Job, run


def main(job: Job) -> None:
    """From the file of the batch and the beds."""
    with time_limit(job.seconds):
        attempts.shake_cases(read_cases(job.input.batch), job.coupon, job.output.batch)


if __name__ == "__main__":
    run(main)
