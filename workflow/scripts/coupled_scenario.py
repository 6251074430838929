"""Integrate panel and particles of a scenario until its rms accelerations are known."""

from pidpanel.coupled.from_study import CoupledFiles, write_scenario
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From panel, sound and beds; the runs are kept in a folder beside the estimate."""
    read, label, folder = job.input, job.params["scenario"], job.folder("folder")
    files = CoupledFiles(read.modes, read.plate, read.get("modal_force"), read.get("air"))
    write_scenario(load_study(job.study), files, label, job.coupon, folder, job.output.estimate)


if __name__ == "__main__":
    run(main)
