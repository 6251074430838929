# The spectrum of the sound and the modal force of its field.


rule sound:
    input:
        modes=results("panel/modes.nc"),
        spectrum=STUDY.sound.spectrum,
    output:
        results("sound/spectrum.csv"),
        results("sound/modal_force.nc"),
    log:
        results("sound/sound.log"),
    params:
        file=STUDY_FILE,
        study=section("sound", "response"),
        code=code("sound"),
    shell:
        "python -m scripts.sound {params.file} {input.modes} {output} 2> {log}"
