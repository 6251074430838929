"""Responses to random and sine motion of the supports, effective masses, notches."""

from pidpanel.base.from_study import write_base
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From panel, damping and coupled runs."""
    damping, coupled = (job.optional_folder(name) for name in ("damping", "coupled"))
    output = {name: getattr(job.output, name) for name in job.output.all}
    write_base(load_study(job.study), job.input, damping, output, coupled)


if __name__ == "__main__":
    run(main)
