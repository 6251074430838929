"""Pour a packing: ``packing.json`` and its files."""

from pidpanel.coupon import attempts, coding
from pidpanel.coupon.packing import Packing
from pidpanel.provenance.job import Job, run
from pidpanel.provenance.requests import read_request


def main(job: Job) -> None:
    """From the values of the packing."""
    packing = coding.decode(Packing, read_request(job.input.values))
    attempts.pour_packing(packing, job.output.packing)


if __name__ == "__main__":
    run(main)
