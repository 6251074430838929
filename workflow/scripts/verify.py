"""Compute one case of a stage that has a known reference: its rows as CSV."""

from pathlib import Path

from pidpanel import job
from pidpanel.verification.rows import verify, write_rows

with job.started(snakemake):
    named = snakemake.wildcards
    write_rows(Path(snakemake.output.rows), verify(named.stage, named.case))
