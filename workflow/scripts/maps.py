"""Rms all over the panel for some scenarios: maps.nc, and a folder for ParaView."""

from pidpanel import job
from pidpanel.response.from_study import write_maps

with job.started(snakemake) as (study, files, output):
    write_maps(study, files, output)
