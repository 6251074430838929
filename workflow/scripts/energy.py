"""Statistical energy: third octaves, one PSD of each point, rms values."""

from pidpanel import job
from pidpanel.energy.from_study import write_energy

with job.started(snakemake) as (study, files, output):
    write_energy(study, files, output, *job.folders(snakemake, "damping", "coupled"))
