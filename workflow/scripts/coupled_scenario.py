"""Integrate panel and particles of a scenario until its rms accelerations are known."""

from pathlib import Path

from pidpanel import job
from pidpanel.coupled.from_study import write_scenario
from pidpanel.paths import COUPON

with job.started(snakemake) as (study, files, output):
    label, folder = snakemake.params.scenario, Path(snakemake.params.folder)
    write_scenario(study, files, label, COUPON, folder, output.estimate)
