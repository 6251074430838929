# The page of a study of the coupon alone.


rule coupon_report:
    input:
        cases=rules.cases.output.cases,
        film=rules.film.output.film,
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
        results("benchmark/coupon_report.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        study=section(),
    message:
        "Report of the coupon"
    script:
        "../scripts/coupon_report.py"
