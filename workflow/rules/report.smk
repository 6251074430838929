# Figures and one page that holds them all.

COUPLED_SHOWN = []
if STUDY.is_coupled:
    COUPLED_SHOWN += [COUPLED[name] for name in ("summary", "psd", "impedance")]
    if len(STUDY.readings) > 1:
        COUPLED_SHOWN.append(results("coupled/verdict.csv"))


rule report:
    input:
        response=[RESPONSE[key] for key in RESPONSE if key not in ("stress", "left_out")],
        maps=MAPS,
        modes=PANEL["modes"],
        mode_table=PANEL["table"],
        section=PANEL["section"],
        spectrum=SOUND["spectrum"],
        cases=[damper_file("coupon", damper, "cases.csv") for damper in STUDY.coupons],
        films=FILMS,
        coupled=COUPLED_SHOWN,
        damping=[
            damper_file("damping", damper, name)
            for damper in STUDY.surfaces
            for name in ("surface.nc", "law.csv", "forms.csv")
        ],
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
        results("benchmark/report.tsv")
    params:
        job=job(results=results("")),
    message:
        "Report"
    shell:
        "python -m scripts.report {params.job:q} 2> {log}"
