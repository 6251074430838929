"""Shake the runs of a case, a folder for each, and write how each ended."""

from pidpanel import job
from pidpanel.coupon.attempts import write_case
from pidpanel.coupon.runs import time_limit
from pidpanel.paths import COUPON

limit = 60 * float(snakemake.config.get("job_minutes", "inf"))
with job.started(snakemake) as (_, _, output), time_limit(limit):
    write_case(snakemake.params.case, COUPON, output.outcome)
