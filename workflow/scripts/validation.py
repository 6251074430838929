"""The page of the experiments, from the rows of all cases."""

from pidpanel.provenance.job import Job, run
from pidpanel.verification.page import write_validation_page


def main(job: Job) -> None:
    """From the rows of all cases."""
    write_validation_page(job.input.several("rows"), job.output.page)


if __name__ == "__main__":
    run(main)
