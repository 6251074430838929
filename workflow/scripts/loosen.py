"""Shake a poured packing loose: ``bed.json`` and its files."""

from pidpanel.coupon import attempts, coding
from pidpanel.coupon.bed import Bed
from pidpanel.provenance.job import Job, run
from pidpanel.provenance.requests import read_request


def main(job: Job) -> None:
    """From the values of the bed and its packing."""
    bed = coding.decode(Bed, read_request(job.input.values))
    attempts.loosen_bed(bed, job.input.packing, job.output.bed)


if __name__ == "__main__":
    run(main)
