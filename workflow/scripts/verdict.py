"""How far each damping model is from the coupled runs: verdict.csv."""

from pidpanel import job
from pidpanel.report.verdict_files import write_verdict

with job.started(snakemake) as (study, files, output):
    write_verdict(study, files.psd, files.summary, files.third_octaves, output.verdict)
