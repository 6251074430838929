"""Measured PSDs and transmissibilities beside computed ones."""

from pidpanel import job
from pidpanel.measurement.from_study import write_measurements
from pidpanel.provenance.files import Files

with job.started(snakemake) as study:
    files, output = Files.from_names(snakemake.input), Files.from_names(snakemake.output)
    curves = {"sound": files.get("response"), "base": files.get("base")}
    write_measurements(
        study, curves, output.measured, output.differences, files, output.get("hammer")
    )
