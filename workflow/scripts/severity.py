"""Oscillator spectra, peaks and fatigue of all responses."""

from pidpanel.provenance.job import Job, run
from pidpanel.severity.from_study import write_severity
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From the PSDs of accelerations and stresses."""
    write_severity(load_study(job.study), job.input, job.output)


if __name__ == "__main__":
    run(main)
