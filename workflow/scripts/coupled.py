"""Tables of the coupled runs of all scenarios."""

from pidpanel.coupled.from_study import write_coupled
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From the estimate of each scenario."""
    write_coupled(load_study(job.study), job.input.several("estimates"), job.output)


if __name__ == "__main__":
    run(main)
