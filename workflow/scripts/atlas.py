"""Write the cases of a coupon as rows of the atlas."""

from pidpanel import job
from pidpanel.coupon.from_study import write_atlas

with job.started(snakemake) as (study, files, output):
    write_atlas(study, files.cases, output.atlas)
