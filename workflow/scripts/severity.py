"""Oscillator spectra, peaks and fatigue of all responses."""

from pidpanel import job
from pidpanel.severity.from_study import write_severity

with job.started(snakemake) as (study, files, output):
    write_severity(study, files, output)
