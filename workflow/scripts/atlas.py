"""Write the cases of a coupon as rows of the atlas."""

from pidpanel.coupon.from_study import write_atlas
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_any_study


def main(job: Job) -> None:
    """From ``results/<study>/coupon/cases.csv``."""
    write_atlas(load_any_study(job.study), job.input.cases, job.output.atlas)


if __name__ == "__main__":
    run(main)
