"""The page of a study with a panel, and its figures."""

from pidpanel.provenance.job import Job, run
from pidpanel.report.from_study import write_study_page


def main(job: Job) -> None:
    """From all results of the study."""
    made = job.output
    write_study_page(job.study, job.folder("results"), made.page, made.figures)


if __name__ == "__main__":
    run(main)
