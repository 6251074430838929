"""Tables of the coupled runs of all scenarios."""

from pidpanel import job
from pidpanel.coupled.from_study import write_coupled
from pidpanel.provenance.files import Files

with job.started(snakemake) as study:
    write_coupled(study, snakemake.input.estimates, Files.from_names(snakemake.output))
