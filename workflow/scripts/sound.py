"""The sound of a study: its spectrum, modal forces and, where it counts, the air."""

from pidpanel import job
from pidpanel.panel.files import read_basis
from pidpanel.sound.from_study import write_sound

with job.started(snakemake) as (study, files, output):
    write_sound(study, read_basis(files.modes), output)
