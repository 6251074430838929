"""From ``cases.csv`` to the surface and the constants of the laws."""

from pidpanel import job
from pidpanel.damping.from_study import write_damping
from pidpanel.provenance.files import Files

with job.started(snakemake) as study:
    damper, cases = snakemake.params.damper, snakemake.input.cases
    write_damping(study, damper, cases, Files.from_names(snakemake.output))
