"""Measured PSDs beside computed ones."""

from pidpanel.measurement.from_study import write_measurements
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From the PSDs of the response."""
    made = job.output
    write_measurements(load_study(job.study), job.input.psd, made.psd, made.differences)


if __name__ == "__main__":
    run(main)
