# Oscillator spectra, peaks in a duration and fatigue of all responses.


rule severity:
    input:
        **RULES["severity"].input,
        request=request_of("severity"),
    output:
        **RULES["severity"].output,
    log:
        RULES["severity"].log,
    benchmark:
        results("benchmark/severity.tsv")
    params:
        job=job(**RULES["severity"].params),
    message:
        "Oscillator spectra, peaks and fatigue"
    shell:
        "python -m scripts.severity {params.job:q} 2> {log}"
