"""The page of the experiments, from the rows of all cases."""

from pidpanel import job
from pidpanel.verification.page import validation_page, write_page

with job.started(snakemake) as (_, files, output):
    write_page(validation_page, files.several("rows"), output.page)
