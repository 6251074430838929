"""Oscillator spectra, peaks and fatigue of all responses."""

from pidpanel import job
from pidpanel.provenance.files import Files
from pidpanel.severity.from_study import write_severity

with job.started(snakemake) as study:
    write_severity(study, Files.from_names(snakemake.input), Files.from_names(snakemake.output))
