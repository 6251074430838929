"""The page of the verification, from the rows of all cases."""

from pidpanel import job
from pidpanel.verification.page import verification_page, write_page

with job.started(snakemake) as (_, files, output):
    write_page(verification_page, files.several("rows"), output.page)
