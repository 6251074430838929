"""Margins of accelerations to the limits of a study."""

from pidpanel import job
from pidpanel.provenance.files import Files
from pidpanel.severity.from_study import write_margins

with job.started(snakemake) as study:
    write_margins(
        study, Files.from_names(snakemake.input), Files.from_names(snakemake.output).margins
    )
