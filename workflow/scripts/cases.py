"""Gather the runs of a coupon: ``cases.csv``."""

from pidpanel import job
from pidpanel.coupon.from_study import write_table
from pidpanel.paths import COUPON

with job.started(snakemake) as (study, _, output):
    write_table(study, snakemake.params.damper, COUPON, output.cases)
