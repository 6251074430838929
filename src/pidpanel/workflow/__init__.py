"""What Snakemake runs: the study, its LIGGGHTS runs, the requests of its jobs."""
