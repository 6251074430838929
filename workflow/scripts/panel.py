"""Mesh and modes of the panel of a study: modes, mesh, section and matrices."""

from pidpanel import job
from pidpanel.structure.from_study import write_panel

with job.started(snakemake) as (study, _, output):
    write_panel(study, output)
