"""How far each damping model is from the coupled runs: verdict.csv."""

from pidpanel.provenance.job import Job, run
from pidpanel.report.verdict_files import write_verdict
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From the PSDs and the tables of the coupled runs."""
    read, study = job.input, load_study(job.study)
    write_verdict(study, read.psd, read.summary, read.third_octaves, job.output.verdict)


if __name__ == "__main__":
    run(main)
