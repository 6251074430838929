# Measured PSDs beside computed ones.


rule measurement:
    input:
        response=rules.response.output.psd if STUDY.sound else [],
        base=(rules.base.output.psd or rules.base.output.sine) if STUDY.base else [],
    output:
        measured=results("measurement/measured.csv"),
        differences=results("measurement/differences.csv"),
    log:
        results("measurement/measurement.log"),
    benchmark:
        results("benchmark/measurement.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        measurements=section("measurements"),
    message:
        "Measured and computed PSDs"
    script:
        "../scripts/measurement.py"


REPORTED += list(rules.measurement.output)
