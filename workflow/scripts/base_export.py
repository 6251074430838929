"""Files for other programs of random motion of the supports: TABRND1, UFF 58, third octaves."""

from pidpanel import job
from pidpanel.base.from_study import write_base_export

with job.started(snakemake) as (study, files, output):
    write_base_export(study, files.modes, files.psd, files.summary, output.folder)
