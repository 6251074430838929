"""Shake a poured packing loose: ``bed.json`` and its files."""

from pathlib import Path

from pidpanel import job
from pidpanel.coupon.attempts import loosen_bed

with job.started(snakemake):
    packing, bed = Path(snakemake.input.packing), Path(snakemake.output.bed)
    loosen_bed(snakemake.params.bed, packing, bed)
