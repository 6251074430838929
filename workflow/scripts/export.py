"""Files for other programs: CSV, third octaves, Nastran TABRND1 and TABDMP1, UFF 58."""

from pidpanel.provenance.job import Job, run
from pidpanel.response.from_study import write_export
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From the modes, the PSDs and their rms values."""
    read = job.input
    write_export(load_study(job.study), read.modes, read.psd, read.summary, job.output.folder)


if __name__ == "__main__":
    run(main)
