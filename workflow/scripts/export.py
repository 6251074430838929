"""Files for other programs: CSV, third octaves, Nastran TABRND1 and TABDMP1, UFF 58."""

from pidpanel import job
from pidpanel.response.from_study import write_export

with job.started(snakemake) as (study, files, output):
    write_export(study, files.modes, files.psd, files.summary, output.folder)
