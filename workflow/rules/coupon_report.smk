# The page of a study of the coupon alone.


rule coupon_report:
    input:
        cases=results("coupon/cases.csv"),
        films=FILMS,
        request=request(results("report.html"), results("report"), study=section()),
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
    params:
        job=job(),
    message:
        "Report of the coupon"
    shell:
        "python -m scripts.coupon_report {params.job:q} 2> {log}"
