# pidpanel: from a study file to the acceleration PSDs of a panel with particle dampers.
#
#   snakemake -j2 --configfile workflow/studies/mine.yaml
#   snakemake -j2 verification        against closed forms and published solutions; no study
#   snakemake -j2 validation          beside experiments of others; no study


include: "workflow/Snakefile"


# of an included file Snakemake takes no target
workflow.default_target = "all"
