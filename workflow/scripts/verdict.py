"""How far each damping model is from the coupled runs: verdict.csv."""

from pidpanel import job
from pidpanel.provenance.files import Files
from pidpanel.report.verdict_files import write_verdict

with job.started(snakemake) as study:
    files, verdict = Files.from_names(snakemake.input), Files.from_names(snakemake.output).verdict
    write_verdict(study, files.psd, files.summary, files.third_octaves, verdict)
