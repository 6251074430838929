# The spectrum of the sound, the modal force of its field and, where it counts, the air's own.


rule sound:
    input:
        modes=rules.panel.output.modes,
    output:
        spectrum=results("sound/spectrum.csv"),
        modal_force=results("sound/modal_force.nc"),
        air=[results("sound/air.nc")] if STUDY.radiation != "none" else [],
    log:
        results("sound/sound.log"),
    benchmark:
        results("benchmark/sound.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        sound=section("sound"),
        highest=STUDY.response.frequency_hz[1],
        air_mass=STUDY.response.air_mass,
        radiation=STUDY.radiation,
    message:
        "Modal forces of the sound"
    script:
        "../scripts/sound.py"


REPORTED += [rules.sound.output.spectrum]
