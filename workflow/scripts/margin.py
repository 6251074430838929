"""Ranges, shares and the next test over the spread of the inputs."""

from pidpanel import job
from pidpanel.margin.from_study import write_margin

with job.started(snakemake) as (study, _, output):
    write_margin(study, *job.folders(snakemake, "damping"), output)
