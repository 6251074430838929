# The spectrum of the sound and the modal force of its field.


rule sound:
    input:
        modes=results("panel/modes.nc"),
        spectrum=STUDY.sound.spectrum,
    output:
        results("sound/spectrum.csv"),
        results("sound/modal_force.nc"),
    params:
        folder=results("sound"),
        study=section("sound", "response"),
        code=code("sound"),
    log:
        results("sound/sound.log"),
    shell:
        "{PYTHON} {SCRIPTS}/sound.py {STUDY_FILE} {input.modes} {params.folder} 2> {log}"
