"""Responses to random and sine motion of the supports, effective masses, notches."""

from pidpanel.base.from_study import BaseFiles, BaseInputs, write_base
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From panel, response and damping."""
    read, made = job.input, job.output
    files = BaseInputs(read.modes, read.plate, read.section, read.left_out)
    optional = ("psd", "summary", "notched", "notches", "sine", "sine_table")
    output = BaseFiles(made.modes_table, *(made.get(name) for name in optional))
    write_base(load_study(job.study), files, job.optional_folder("damping"), output)


if __name__ == "__main__":
    run(main)
