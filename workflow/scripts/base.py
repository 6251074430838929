"""Responses to random and sine motion of the supports, effective masses, notches."""

from pidpanel.base.from_study import BaseInputs, write_base
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From panel, damping and coupled runs."""
    read, made = job.input, job.output
    files = BaseInputs(read.modes, read.plate, read.section)
    damping, coupled = (job.optional_folder(name) for name in ("damping", "coupled"))
    output = {name: getattr(made, name) for name in made.all}
    write_base(load_study(job.study), files, damping, output, coupled)


if __name__ == "__main__":
    run(main)
