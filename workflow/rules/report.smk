# Figures and one page that holds them all; each stage has named the files that the page shows.


rule report:
    input:
        stages=REPORTED,
        cases=[damper_file("coupon", damper, "cases.csv") for damper in STUDY.coupons],
        films=[damper_file("coupon", damper, "film.nc") for damper in STUDY.coupons],
        damping=[
            damper_file("damping", damper, name)
            for damper in STUDY.coupons
            for name in ("surface.nc", "law.csv")
        ],
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
    benchmark:
        results("benchmark/report.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        study=section(),
        results=lambda wildcards, output: str(Path(output.page).parent),
    message:
        "Report"
    script:
        "../scripts/report.py"
