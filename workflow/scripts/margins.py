"""Margins of accelerations to the limits of a study."""

from pidpanel import job
from pidpanel.severity.from_study import write_margins

with job.started(snakemake) as (study, files, output):
    write_margins(study, files, output.margins)
