"""From ``cases.csv`` to the surface and the constants of the laws."""

from pidpanel.damping.from_study import write_damping
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From the cases of a coupon."""
    study, damper = load_study(job.study), job.params["damper"]
    write_damping(study, damper, job.input.cases, job.output)


if __name__ == "__main__":
    run(main)
