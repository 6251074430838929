"""Files for other programs: CSV, third octaves, Nastran TABRND1 and TABDMP1, UFF 58."""

from pidpanel import job
from pidpanel.provenance.files import Files
from pidpanel.response.from_study import write_export

with job.started(snakemake) as study:
    files, folder = Files.from_names(snakemake.input), Files.from_names(snakemake.output).folder
    write_export(study, files.modes, files.psd, files.summary, folder)
