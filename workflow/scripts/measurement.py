"""Measured PSDs and transmissibilities beside computed ones."""

from pidpanel import job
from pidpanel.measurement.from_study import write_measurements

with job.started(snakemake) as (study, files, output):
    curves = {"sound": files.get("response"), "base": files.get("base")}
    tables = output.measured, output.differences
    write_measurements(study, curves, *tables, files, output.get("hammer"))
