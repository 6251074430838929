# The page of a study of the coupon alone.


rule coupon_report:
    input:
        cases=results("coupon/cases.csv"),
        template=str(PROJECT / "templates/report/report.html.j2"),
    output:
        page=results("report.html"),
        figures=directory(results("report")),
    log:
        results("report.log"),
    params:
        file=STUDY_FILE,
        study=json.dumps(STUDY.model_dump(mode="json"), sort_keys=True),
        code=code("report"),
    shell:
        "python -m scripts.coupon_report {params.file} {input.cases} results/coupon"
        " {output} 2> {log}"
