"""Oscillator spectra, peaks and fatigue of all responses."""

from pidpanel.provenance.job import Job, run
from pidpanel.severity.from_study import ResponseTables, SeverityFiles, write_severity
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From the PSDs of accelerations and stresses."""
    read, made = job.input, job.output
    tables = (made.oscillators, made.peaks, made.fatigue, made.strength, made.margins)
    output = SeverityFiles(*tables, made.get("maps"))
    files = ResponseTables(read.psd, read.summary, read.stress, read.stress_table, read.get("maps"))
    write_severity(load_study(job.study), files, output)


if __name__ == "__main__":
    run(main)
