"""The page of a study with a panel, and its figures."""

from pathlib import Path

from pidpanel import job
from pidpanel.report.from_study import write_study_page

with job.started(snakemake) as (study, _, output):
    folder = Path(snakemake.params.results)
    write_study_page(study, snakemake.config["file"], folder, output.page, output.figures)
