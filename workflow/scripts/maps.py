"""Rms all over the panel for some scenarios: maps.nc, and a folder for ParaView."""

from pidpanel import job
from pidpanel.provenance.files import Files
from pidpanel.response.from_study import write_maps

with job.started(snakemake) as study:
    write_maps(study, Files.from_names(snakemake.input), Files.from_names(snakemake.output))
