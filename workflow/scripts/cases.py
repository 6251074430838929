"""Gather the runs of a coupon: ``cases.csv``."""

from pidpanel import job
from pidpanel.coupon.from_study import write_table
from pidpanel.paths import COUPON

with job.started(snakemake) as study:
    write_table(study, snakemake.params.damper, COUPON, snakemake.output.cases)
