"""Pour a packing: ``packing.json`` and its files."""

from pathlib import Path

from pidpanel import job
from pidpanel.coupon.attempts import pour_packing

with job.started(snakemake):
    pour_packing(snakemake.params.packing, Path(snakemake.output.packing))
