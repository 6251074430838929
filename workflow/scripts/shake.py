"""Shake the runs of a case, a folder for each, and write how each ended."""

from pathlib import Path

from pidpanel import job
from pidpanel.coupon.attempts import write_case
from pidpanel.coupon.runs import time_limit
from pidpanel.paths import COUPON

with job.started(snakemake), time_limit(60 * float(snakemake.config.get("job_minutes", "inf"))):
    write_case(snakemake.params.case, COUPON, Path(snakemake.output.outcome))
