"""Rms all over the panel for some scenarios: maps.nc, and a folder for ParaView."""

from pidpanel.provenance.job import Job, run
from pidpanel.response.from_study import write_maps
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From panel, sound and response."""
    write_maps(load_study(job.study), job.input, job.output)


if __name__ == "__main__":
    run(main)
