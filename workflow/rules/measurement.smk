# Measured PSDs beside computed ones.


IS_HIT = any(measurement.drive for measurement in STUDY.measurements.values())


rule measurement:
    input:
        response=rules.response.output.psd if STUDY.sound else [],
        base=(rules.base.output.psd or rules.base.output.sine) if STUDY.base else [],
        modes=rules.panel.output.modes if IS_HIT else [],
        plate=rules.panel.output.plate if IS_HIT else [],
        modal_force=rules.sound.output.modal_force if IS_HIT and STUDY.sound else [],
        air=rules.sound.output.air if IS_HIT and STUDY.sound else [],
    output:
        measured=results("measurement/measured.csv"),
        differences=results("measurement/differences.csv"),
        hammer=[results("measurement/hammer.nc")] if IS_HIT else [],
    log:
        results("measurement/measurement.log"),
    benchmark:
        results("benchmark/measurement.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        measurements=section("measurements"),
        damping_ratio=section("panel")["panel"]["damping_ratio"],
    message:
        "Measured and computed PSDs"
    script:
        "../scripts/measurement.py"


REPORTED += list(rules.measurement.output)
