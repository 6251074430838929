# The page of a study of the coupon alone.


rule coupon_report:
    input:
        cases=results("coupon/cases.csv"),
        films=FILMS,
        rests=rests(
            results("report.html"),
            results("report"),
            study=section(),
            files=content(*PAGE_FILES),
            code=code("coupon_report"),
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
    shell:
        'python -m scripts.coupon_report "$PIDPANEL_STUDY" {input.cases} results/coupon'
        " {output} --made {input.rests} --to {output} 2> {log}"
