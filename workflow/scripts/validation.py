"""The page of the experiments, from the rows of all cases."""

from pathlib import Path

from pidpanel import job
from pidpanel.verification.page import validation_page, write_page

with job.started(snakemake):
    write_page(validation_page, snakemake.input.rows, Path(snakemake.output.page))
