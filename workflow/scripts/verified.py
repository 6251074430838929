"""Fail where a number of the verification misses its tolerance; else count the numbers."""

from pathlib import Path

from pidpanel import job
from pidpanel.verification.rows import confirm, read_rows

with job.started(snakemake):
    text = confirm([row for file in snakemake.input.rows for row in read_rows(Path(file))])
    Path(snakemake.output.verdict).write_text(f"{text}\n", encoding="utf-8")
