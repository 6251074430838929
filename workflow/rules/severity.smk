# Oscillator spectra, peaks in a duration and fatigue of all responses; margins to limits.

if STUDY.severity is not None:
    HAS_STRENGTH = STUDY.severity.strength is not None

    rule severity:
        input:
            psd=rules.response.output.psd,
            summary=rules.response.output.summary,
            stress=rules.response.output.stress,
            stress_table=rules.response.output.stress_table,
            maps=rules.maps.output.maps if HAS_STRENGTH else [],
            coupled=rules.coupled.output.summary if STUDY.is_coupled else [],
        output:
            oscillators=results("severity/oscillators.csv"),
            peaks=results("severity/peaks.csv"),
            fatigue=results("severity/fatigue.csv"),
            strength=results("severity/strength.csv"),
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


if STUDY.limits:
    SHAKEN = STUDY.base is not None and BASE_PARTS["random"]

    rule margins:
        input:
            psd=rules.response.output.psd if STUDY.sound else [],
            summary=rules.response.output.summary if STUDY.sound else [],
            base_psd=rules.base.output.psd if SHAKEN else [],
            base_summary=rules.base.output.summary if SHAKEN else [],
        output:
            margins=results("severity/margins.csv"),
        log:
            results("severity/margins.log"),
        benchmark:
            results("benchmark/margins.tsv")
        resources:
            mem_mb=1000,
        params:
            version=VERSION,
            limits=section("limits"),
        message:
            "Margins to the limits"
        script:
            "../scripts/margins.py"

    REPORTED += list(rules.margins.output)
