"""Tables of the coupled runs of all scenarios."""

from pidpanel import job
from pidpanel.coupled.from_study import write_coupled

with job.started(snakemake) as (study, files, output):
    write_coupled(study, files.several("estimates"), output)
