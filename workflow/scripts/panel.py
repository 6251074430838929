"""Mesh and modes of the panel of a study: modes, mesh, section and matrices."""

import pidpanel.panel.files
import pidpanel.panel.tables  # noqa: F401 - a fork of many does not import them again
from pidpanel.panel.from_study import write_panel
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From the study alone."""
    write_panel(load_study(job.study), job.output)


if __name__ == "__main__":
    run(main)
