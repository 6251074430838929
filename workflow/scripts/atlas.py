"""Write the cases of a coupon as rows of the atlas."""

from pidpanel import job
from pidpanel.coupon.from_study import write_atlas

with job.started(snakemake) as study:
    write_atlas(study, snakemake.input.cases, snakemake.output.atlas)
