"""Shake a poured packing loose: ``bed.json`` and its files."""

from pidpanel import job
from pidpanel.coupon.attempts import loosen_bed

with job.started(snakemake) as (_, files, output):
    loosen_bed(snakemake.params.bed, files.packing, output.bed)
