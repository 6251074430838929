"""The page of a study of the coupon alone, and its figures."""

from pidpanel import job
from pidpanel.report.from_study import write_coupon_page

with job.started(snakemake) as (study, files, output):
    write_coupon_page(study, snakemake.config["file"], files.cases, output.page, output.figures)
