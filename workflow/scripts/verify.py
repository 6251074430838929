"""Compute one case of a stage that has a known reference: its rows as CSV."""

from pidpanel.provenance.job import Job, run
from pidpanel.verification.rows import verify, write_rows


def main(job: Job) -> None:
    """From nothing but the code."""
    write_rows(job.output.rows, verify(job.params["stage"], job.params["case"]))


if __name__ == "__main__":
    run(main)
