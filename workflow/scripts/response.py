"""Every scenario with every damping model: PSDs, rms values, stress, radiation."""

from pidpanel.provenance.job import Job, run
from pidpanel.response.from_study import PanelFiles, ResponseFiles, write_response
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From panel, sound, damping and coupled runs."""
    read, made = job.input, job.output
    files = PanelFiles(read.modes, read.modal_force, read.get("air"))
    damping, coupled = (job.optional_folder(name) for name in ("damping", "coupled"))
    tables = (made.psd, made.summary, made.layouts, made.stress, made.stress_table, made.left_out)
    output = ResponseFiles(*tables)
    write_response(load_study(job.study), files, read.plate, read.section, damping, output, coupled)


if __name__ == "__main__":
    run(main)
