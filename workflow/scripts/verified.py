"""Fail where a number of the verification misses its tolerance; else count the numbers."""

from pidpanel import job
from pidpanel.verification.rows import confirm, read_rows

with job.started(snakemake) as (_, files, output):
    text = confirm([row for file in files.several("rows") for row in read_rows(file)])
    output.verdict.write_text(f"{text}\n", encoding="utf-8")
