"""Shake runs of a long case for so long: a status, and restarts for the next leg."""

from pidpanel.coupon.attempts import shake_leg
from pidpanel.provenance.job import Job, run


def main(job: Job) -> None:
    """From the request, the beds and the leg before."""
    before = job.input.get("before")
    shake_leg(job.input.request, before, job.coupon, job.output.leg, seconds=job.seconds)


if __name__ == "__main__":
    run(main)
