"""Measured PSDs and transmissibilities beside computed ones."""

from pidpanel.measurement.from_study import write_measurements
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From the curves of the response and of base motion."""
    read, made = job.input, job.output
    curves = {"sound": read.get("response"), "base": read.get("base")}
    write_measurements(load_study(job.study), curves, made.measured, made.differences)


if __name__ == "__main__":
    run(main)
