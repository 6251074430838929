# Figures and one page that holds them all.


rule report:
    input:
        **RULES["report"].input,
        request=request_of("report"),
        response=[RESPONSE[key] for key in RESPONSE if key not in ("stress", "left_out")],
        maps=MAPS,
        modes=PANEL["modes"],
        mode_table=PANEL["table"],
        section=PANEL["section"],
        spectrum=SOUND["spectrum"],
        cases=[damper_file("coupon", damper, "cases.csv") for damper in STUDY.coupons],
        films=FILMS,
        coupled=COUPLED_SHOWN,
        severity=list(SEVERITY.values()) if STUDY.severity is not None else [],
        damping=[
            damper_file("damping", damper, name)
            for damper in STUDY.surfaces
            for name in ("surface.nc", "law.csv", "forms.csv")
        ],
        request=request(results("report.html"), results("report"), study=section()),
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
