"""What Snakemake is told to run: the study, its LIGGGHTS runs, the requests of its jobs."""
