"""From ``cases.csv`` to the surface and the constants of the laws."""

from pidpanel import job
from pidpanel.damping.from_study import write_damping

with job.started(snakemake) as (study, files, output):
    write_damping(study, snakemake.params.damper, files.cases, output)
