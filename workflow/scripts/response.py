"""Every scenario: PSDs, rms values, stress, radiation."""

from pidpanel import job
from pidpanel.provenance.files import Files
from pidpanel.response.from_study import write_response

with job.started(snakemake) as study:
    files, output = Files.from_names(snakemake.input), Files.from_names(snakemake.output)
    write_response(study, files, output, *job.folders(snakemake, "damping", "coupled"))
