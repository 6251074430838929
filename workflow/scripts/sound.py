"""The sound of a study: its spectrum, modal forces and, where it counts, the air."""

from pidpanel.panel.files import read_basis
from pidpanel.provenance.job import Job, run
from pidpanel.sound.from_study import write_sound
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From the modes of the panel."""
    write_sound(load_study(job.study), read_basis(job.input.modes), job.output)


if __name__ == "__main__":
    run(main)
