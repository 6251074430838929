# Measured PSDs beside computed ones.


rule measurement:
    input:
        **RULES["measurement"].input,
        request=request_of("measurement"),
    output:
        **RULES["measurement"].output,
    log:
        RULES["measurement"].log,
    benchmark:
        results("benchmark/measurement.tsv")
    params:
        job=job(**RULES["measurement"].params),
    message:
        "Measured and computed PSDs"
    shell:
        "python -m scripts.measurement {params.job:q} 2> {log}"
