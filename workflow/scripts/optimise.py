"""Layouts proposed within a mass budget."""

from pidpanel.optimise.from_study import ProposalFiles, ProposalInputs, write_proposal
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From panel, sound and damping."""
    read, made = job.input, job.output
    files = ProposalInputs(
        read.modes, read.plate, read.section, read.get("modal_force"), read.get("air")
    )
    output = ProposalFiles(made.layouts, made.front, made.summary, made.search, made.psd)
    write_proposal(load_study(job.study), files, job.optional_folder("damping"), output)


if __name__ == "__main__":
    run(main)
