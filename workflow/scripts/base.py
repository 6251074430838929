"""Responses to random and sine motion of the supports, effective masses, notches."""

from pidpanel import job
from pidpanel.base.from_study import write_base
from pidpanel.provenance.files import Files

with job.started(snakemake) as study:
    files, output = Files.from_names(snakemake.input), Files.from_names(snakemake.output)
    damping, coupled = job.folders(snakemake, "damping", "coupled")
    write_base(study, files, damping, output, coupled)
