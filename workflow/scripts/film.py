"""Watch one run of a coupon for some cycles: ``film.nc``, for the animation on the page."""

from pidpanel import job
from pidpanel.coupon.from_study import cases_by_coupon
from pidpanel.paths import COUPON
from pidpanel.provenance.digests import stamp
from pidpanel.report.films import write_film

with job.started(snakemake) as (study, files, output):
    cases = cases_by_coupon(study)[snakemake.params.damper]
    write_film(cases, stamp(study), files.cases, COUPON, output.film)
