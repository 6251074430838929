"""The page of a study of the coupon alone, and its figures."""

from pidpanel import job
from pidpanel.report.from_study import write_coupon_page

with job.started(snakemake) as study:
    cases, output = snakemake.input.cases, snakemake.output
    write_coupon_page(study, snakemake.config["file"], cases, output.page, output.figures)
