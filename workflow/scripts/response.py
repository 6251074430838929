"""Every scenario: PSDs, rms values, stress, radiation."""

from pidpanel import job
from pidpanel.response.from_study import write_response

with job.started(snakemake) as (study, files, output):
    write_response(study, files, output, *job.folders(snakemake, "damping", "coupled"))
