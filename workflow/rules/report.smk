# Figures and one page that holds them all.


rule report:
    input:
        **RULES["report"].input,
        request=request_of("report"),
    output:
        page=report(
            RULES["report"].output["page"],
            caption="../report/page.rst",
            category="Pages",
            labels={"study": STUDY.name},
        ),
        figures=directory(RULES["report"].output["figures"]),
    log:
        RULES["report"].log,
    benchmark:
        results("benchmark/report.tsv")
    params:
        job=job(**RULES["report"].params),
    message:
        "Report"
    shell:
        "python -m scripts.report {params.job:q} 2> {log}"
