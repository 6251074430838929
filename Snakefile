# pidpanel: from a study file to the acceleration PSDs of a panel with particle dampers.
#
#   snakemake -j2 --configfile workflow/studies/mine.yaml


include: "workflow/rules/common.smk"
include: "workflow/rules/coupon.smk"


rule all:
    default_target: True
    input:
        results("coupon/cases.csv"),
