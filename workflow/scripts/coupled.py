"""Tables of the coupled runs of all scenarios."""

from pidpanel.coupled.from_study import CoupledFiles, CoupledTables, write_coupled
from pidpanel.provenance.job import Job, run
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From panel, sound and the estimate of each scenario."""
    read, made = job.input, job.output
    files = CoupledFiles(read.modes, read.modal_force, read.plate, read.get("air"))
    tables = CoupledTables(made.summary, made.third_octaves, made.impedance, made.psd)
    write_coupled(load_study(job.study), files, read.several("estimates"), tables)


if __name__ == "__main__":
    run(main)
