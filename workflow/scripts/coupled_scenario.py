"""Integrate panel and particles of a scenario until its rms accelerations are known."""

from pathlib import Path

from pidpanel import job
from pidpanel.coupled.from_study import write_scenario
from pidpanel.paths import COUPON
from pidpanel.provenance.files import Files

with job.started(snakemake) as study:
    label, folder = snakemake.params.scenario, Path(snakemake.params.folder)
    estimate = Path(snakemake.output.estimate)
    write_scenario(study, Files.from_names(snakemake.input), label, COUPON, folder, estimate)
