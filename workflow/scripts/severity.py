"""Oscillator spectra, peaks and fatigue of all responses."""

from pidpanel import job
from pidpanel.provenance.files import Files
from pidpanel.severity.from_study import write_severity

with job.started(snakemake) as study:
    write_severity(study, Files.of(snakemake.input), Files.of(snakemake.output))
