"""Layouts proposed within a mass budget."""

from pidpanel import job
from pidpanel.optimise.from_study import write_proposal

with job.started(snakemake) as (study, files, output):
    write_proposal(study, files, *job.folders(snakemake, "damping"), output)
