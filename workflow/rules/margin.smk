# g rms over the spread of all inputs, their shares, and the next test.


rule margin:
    input:
        surfaces=SURFACES,
    output:
        runs=results("margin/runs.nc"),
        ranges=results("margin/ranges.csv"),
        shares=results("margin/shares.csv"),
        next_test=results("margin/next_test.csv"),
        inputs=[results("margin/inputs.csv")] if STUDY.update else [],
        tests=[results("margin/tests.csv")] if STUDY.update else [],
    log:
        results("margin/margin.log"),
    benchmark:
        results("benchmark/margin.tsv")
    threads: 2
    resources:
        mem_mb=2000,
    params:
        version=VERSION,
        damping=lambda wildcards: results("damping") if SURFACES else None,
        study=section(
            *("damping", "panel", "sound", "response", "limits", "uncertain", "margin"),
            *("measurements", "update"),
            without={"response": {"maps"}, "damping": {"coupled"}},
        ),
        dampers=used_dampers(),
        scenarios=scenarios(),
    message:
        "Margin over the spread of the inputs"
    script:
        "../scripts/margin.py"


REPORTED += list(rules.margin.output)
