# pidpanel: from a study file to the acceleration PSDs of a panel with particle dampers.
#
#   snakemake -j2 --configfile workflow/studies/mine.yaml
#   snakemake -j2 verification        against closed forms and published solutions; no study


# `docker build -t pidpanel .` makes it; needed only with --software-deployment-method apptainer
container: "docker-daemon://pidpanel:latest"


include: "workflow/rules/common.smk"
include: "workflow/rules/coupon.smk"
include: "workflow/rules/film.smk"


if HAS_PANEL:

    include: "workflow/rules/panel.smk"
    include: "workflow/rules/sound.smk"
    include: "workflow/rules/damping.smk"
    include: "workflow/rules/response.smk"
    include: "workflow/rules/random.smk"
    include: "workflow/rules/design.smk"
    include: "workflow/rules/report.smk"

    if STUDY.is_coupled:

        include: "workflow/rules/coupled.smk"

else:

    include: "workflow/rules/coupon_report.smk"


include: "workflow/rules/verification.smk"


rule all:
    default_target: True
    input:
        results("report.html"),
        results("response/export") if HAS_PANEL else [],
