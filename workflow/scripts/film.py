"""Watch one run of a coupon for some cycles: ``film.nc``, for the animation on the page."""

from pidpanel.coupon.from_study import cases_by_coupon
from pidpanel.provenance.digests import stamp
from pidpanel.provenance.job import Job, run
from pidpanel.report.films import write_film
from pidpanel.study import load_any_study


def main(job: Job) -> None:
    """From the cases and the runs of the coupon."""
    study = load_any_study(job.study)
    cases = cases_by_coupon(study)[job.params["damper"]]
    write_film(cases, stamp(study), job.input.cases, job.coupon, job.output.film)


if __name__ == "__main__":
    run(main)
