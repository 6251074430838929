"""Integrate panel and particles of a scenario until its rms accelerations are known."""

from pidpanel.coupled.from_study import write_scenario
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From panel, sound and beds; the runs are kept in a folder beside the estimate."""
    label, folder = job.params["scenario"], job.folder("folder")
    write_scenario(load_study(job.study), job.input, label, job.coupon, folder, job.output.estimate)


if __name__ == "__main__":
    run(main)
