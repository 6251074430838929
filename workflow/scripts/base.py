"""Responses to random and sine motion of the supports, effective masses, notches."""

from pidpanel import job
from pidpanel.base.from_study import write_base

with job.started(snakemake) as (study, files, output):
    damping, coupled = job.folders(snakemake, "damping", "coupled")
    write_base(study, files, damping, output, coupled)
