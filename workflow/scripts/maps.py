"""Rms all over the panel for some scenarios: maps.nc, and a folder for ParaView."""

from pidpanel.provenance.job import Job, run
from pidpanel.response.from_study import PanelFiles, write_maps
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From panel, sound and response."""
    read, made = job.input, job.output
    files = PanelFiles(read.modes, read.modal_force, read.get("air"))
    upstream = (read.plate, read.left_out, read.psd, read.get("coupled"))
    write_maps(load_study(job.study), files, *upstream, made.maps, made.folder)


if __name__ == "__main__":
    run(main)
