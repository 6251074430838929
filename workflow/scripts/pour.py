"""Pour a packing: ``packing.json`` and its files."""

from pidpanel import job
from pidpanel.coupon.attempts import pour_packing

with job.started(snakemake) as (_, _, output):
    pour_packing(snakemake.params.packing, output.packing)
