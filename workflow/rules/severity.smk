# Oscillator spectra, peaks in a duration and fatigue of all responses.

SEVERITY = {name: results(f"severity/{name}.csv") for name in ("oscillators", "peaks", "fatigue")}


rule severity:
    input:
        **{name: RESPONSE[name] for name in ("psd", "summary", "stress", "stress_table")},
        request=request(*SEVERITY.values(), study=section("severity")),
    output:
        **SEVERITY,
    log:
        results("severity/severity.log"),
    benchmark:
        results("benchmark/severity.tsv")
    params:
        job=job(),
    message:
        "Oscillator spectra, peaks and fatigue"
    shell:
        "python -m scripts.severity {params.job:q} 2> {log}"
