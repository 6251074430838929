"""Watch one run of a coupon for some cycles: ``film.nc``, for the animation on the page."""

from pidpanel.provenance.job import Job, run
from pidpanel.report.films import write_film
from pidpanel.study import load_any_study


def main(job: Job) -> None:
    """From the cases and the runs of the coupon."""
    study, damper = load_any_study(job.study), job.params["damper"]
    write_film(study, damper, job.input.cases, job.coupon, job.output.film)


if __name__ == "__main__":
    run(main)
