"""What Snakemake runs: the study, its LIGGGHTS runs, its rules."""
