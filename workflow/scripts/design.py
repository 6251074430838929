"""The next round of tones: which to run, or that there are enough."""

from pidpanel.provenance.job import Job, run
from pidpanel.response.from_study import PanelFiles
from pidpanel.sampling.from_study import write_round
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From panel, sound, and the round before with its cases."""
    read, before = job.input, (job.input.get("before"), job.input.get("cases"))
    files = PanelFiles(read.modes, read.modal_force, read.get("air"))
    write_round(load_study(job.study), files, *before, job.output.round)


if __name__ == "__main__":
    run(main)
