"""Compute one case of a stage that has a known reference: its rows as CSV."""

from pidpanel import job
from pidpanel.verification.rows import verify, write_rows

with job.started(snakemake) as (_, _, output):
    named = snakemake.wildcards
    write_rows(output.rows, verify(named.stage, named.case))
