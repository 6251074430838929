"""Every scenario with every damping model: PSDs, rms values, stress, radiation."""

from pidpanel.provenance.job import Job, run
from pidpanel.response.from_study import write_response
from pidpanel.study import load_study


def main(job: Job) -> None:
    """From panel, sound, damping and coupled runs."""
    damping, coupled = (job.optional_folder(name) for name in ("damping", "coupled"))
    write_response(load_study(job.study), job.input, job.output, damping, coupled)


if __name__ == "__main__":
    run(main)
