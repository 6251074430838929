"""Inputs of Snakemake: the study, its LIGGGHTS runs, the requests of its jobs."""
