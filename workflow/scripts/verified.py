"""Fail where a number of the verification misses its tolerance; else count the numbers."""

from pidpanel.provenance.job import Job, run
from pidpanel.verification.rows import confirm, read_rows


def main(job: Job) -> None:
    """From the rows of all cases."""
    text = confirm([row for file in job.input.several("rows") for row in read_rows(file)])
    job.output.verdict.write_text(f"{text}\n", encoding="utf-8")


if __name__ == "__main__":
    run(main)
