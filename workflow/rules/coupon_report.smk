# The page of a study of the coupon alone.


rule coupon_report:
    input:
        cases=results("coupon/cases.csv"),
        films=FILMS,
    output:
        page=results("report.html"),
        figures=directory(results("report")),
    log:
        results("report.log"),
    params:
        study=section(),
        files=content(*PAGE_FILES),
        code=code("coupon_report"),
    shell:
        'python -m scripts.coupon_report "$PIDPANEL_STUDY" {input.cases} results/coupon'
        " {output} 2> {log}"
