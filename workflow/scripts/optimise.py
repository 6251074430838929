"""Layouts proposed within a mass budget."""

from pidpanel import job
from pidpanel.optimise.from_study import write_proposal
from pidpanel.provenance.files import Files

with job.started(snakemake) as study:
    (damping,) = job.folders(snakemake, "damping")
    write_proposal(
        study, Files.from_names(snakemake.input), damping, Files.from_names(snakemake.output)
    )
