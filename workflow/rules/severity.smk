# Oscillator spectra, peaks in a duration and fatigue of all responses.

HAS_STRENGTH = STUDY.severity.strength is not None


rule severity:
    input:
        psd=rules.response.output.psd,
        summary=rules.response.output.summary,
        stress=rules.response.output.stress,
        stress_table=rules.response.output.stress_table,
        maps=rules.maps.output.maps if HAS_STRENGTH else [],
    output:
        oscillators=results("severity/oscillators.csv"),
        peaks=results("severity/peaks.csv"),
        fatigue=results("severity/fatigue.csv"),
        strength=results("severity/strength.csv"),
        margins=results("severity/margins.csv"),
        maps=[results("severity/maps.nc")] if HAS_STRENGTH else [],
    log:
        results("severity/severity.log"),
    benchmark:
        results("benchmark/severity.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        severity=section("severity"),
    message:
        "Oscillator spectra, peaks and fatigue"
    script:
        "../scripts/severity.py"


REPORTED += list(rules.severity.output)
