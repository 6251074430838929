"""Layouts proposed within a mass budget."""

from pidpanel.optimise.from_study import write_proposal
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From panel, sound and damping."""
    write_proposal(load_study(job.study), job.input, job.optional_folder("damping"), job.output)


if __name__ == "__main__":
    run(main)
