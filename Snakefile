# pidpanel: from a study file to the acceleration PSDs of a panel with particle dampers.
#
#   snakemake -j2 --configfile workflow/studies/mine.yaml


include: "workflow/Snakefile"


# of an included file Snakemake takes no target
workflow.default_target = "all"
