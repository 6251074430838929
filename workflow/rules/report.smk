# Figures and one page that holds them all.

CASES_CSV = [coupon_file("coupon", damper, "cases.csv") for damper in STUDY.coupons]
COUPLED_SHOWN = ["summary", "psd", "impedance"]
if len(STUDY.readings) > 1:
    COUPLED_SHOWN.append("verdict")
DAMPING_FILES = [
    coupon_file("damping", damper, name)
    for damper in STUDY.surfaces
    for name in ("surface.nc", "law.csv", "forms.csv")
]


rule report:
    input:
        psd=results("response/psd.nc"),
        summary=results("response/summary.csv"),
        layouts=results("response/layouts.csv"),
        stress=results("response/stress.csv"),
        beside=BESIDE,
        maps=results("response/maps.nc"),
        modes=results("panel/modes.nc"),
        mode_table=results("panel/modes.csv"),
        section=results("panel/section.csv"),
        spectrum=results("sound/spectrum.csv"),
        cases=CASES_CSV,
        films=FILMS,
        coupled=[results(f"coupled/{n}.csv") for n in COUPLED_SHOWN] if STUDY.is_coupled else [],
        damping=DAMPING_FILES,
        rests=rests(
            results("report.html"),
            results("report"),
            study=section(),
            files=content(PAPER_TABLE, *PAGE_FILES),
            code=code("report"),
        ),
    output:
        page=report(
            results("report.html"),
            caption="../report/page.rst",
            category="Pages",
            labels={"study": STUDY.name},
        ),
        figures=directory(results("report")),
    log:
        results("report.log"),
    params:
        folder=lambda wildcards, output: str(Path(output.page).parent),
    shell:
        'python -m scripts.report "$PIDPANEL_STUDY" {params.folder} results/coupon'
        " --made {input.rests} --to {output} 2> {log}"
