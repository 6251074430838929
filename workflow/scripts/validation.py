"""The page of the experiments, from the rows of all cases."""

from pidpanel.provenance.job import Job, run
from pidpanel.verification.page import validation_page, write_page


def main(job: Job) -> None:
    """From the rows of all cases."""
    write_page(validation_page, job.input.several("rows"), job.output.page)


if __name__ == "__main__":
    run(main)
