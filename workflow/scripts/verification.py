"""The page of the verification, from the rows of all cases."""

from pathlib import Path

from pidpanel import job
from pidpanel.verification.page import verification_page, write_page

with job.started(snakemake):
    write_page(verification_page, snakemake.input.rows, Path(snakemake.output.page))
