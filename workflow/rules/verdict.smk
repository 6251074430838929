# How far each damping model is from the coupled runs.


rule verdict:
    input:
        psd=rules.response.output.psd,
        summary=rules.coupled.output.summary,
        third_octaves=rules.coupled.output.third_octaves,
    output:
        verdict=results("coupled/verdict.csv"),
    log:
        results("verdict.log"),
    benchmark:
        results("benchmark/verdict.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        scenarios=scenarios(),
        dampers=used_dampers(),
    message:
        "Damping models against the coupled runs"
    script:
        "../scripts/verdict.py"


REPORTED += list(rules.verdict.output) if STUDY.has_verdict else []
