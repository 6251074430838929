"""Mesh and modes of the panel of a study: modes, mesh, section and matrices."""

from pidpanel import job
from pidpanel.panel.from_study import write_panel
from pidpanel.provenance.files import Files

with job.started(snakemake) as study:
    write_panel(study, Files.from_names(snakemake.output))
