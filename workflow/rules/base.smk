# Random and sine motion of the supports: responses, effective masses, notches.

BASE_PARTS = STUDY.base.parts


rule base:
    input:
        modes=rules.panel.output.modes,
        plate=rules.panel.output.plate,
        section=rules.panel.output.section,
        surfaces=SURFACES,
        coupled=COUPLED,
    output:
        modes_table=results("base/modes.csv"),
        psd=[results("base/psd.nc")] if BASE_PARTS["random"] else [],
        psd_table=[results("base/psd.csv")] if BASE_PARTS["random"] else [],
        summary=[results("base/summary.csv")] if BASE_PARTS["random"] else [],
        notched=[results("base/notched.csv")] if BASE_PARTS["notching"] else [],
        sine=[results("base/sine.nc")] if BASE_PARTS["sine"] else [],
        sine_table=[results("base/sine.csv")] if BASE_PARTS["sine"] else [],
    log:
        results("base/base.log"),
    benchmark:
        results("benchmark/base.tsv")
    resources:
        mem_mb=2000,
    params:
        version=VERSION,
        damping=lambda wildcards: results("damping") if SURFACES else None,
        coupled=lambda wildcards: results("coupled") if COUPLED else None,
        study=section("base", "damping", "panel", "sound", "response"),
        dampers=used_dampers(),
        scenarios=scenarios(),
    message:
        "Response to base motion"
    script:
        "../scripts/base.py"


if BASE_PARTS["random"]:

    rule base_export:
        input:
            modes=rules.panel.output.modes,
            psd=rules.base.output.psd,
            summary=rules.base.output.summary,
        output:
            folder=directory(results("base/export")),
        log:
            results("base/export.log"),
        benchmark:
            results("benchmark/base_export.tsv")
        resources:
            mem_mb=1000,
        params:
            version=VERSION,
        message:
            "Files for other programs: base motion"
        script:
            "../scripts/base_export.py"


REPORTED += list(rules.base.output)
