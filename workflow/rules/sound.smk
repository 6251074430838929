# The spectrum of the sound, the modal force of its field and, where it counts, the air's own.

RADIATION = {STUDY.response.radiation, STUDY.response.radiation_beside} - {"none"}
AIR = [results("sound/air.nc")] if RADIATION else []


SOUND = [results("sound/spectrum.csv"), results("sound/modal_force.nc"), *AIR]


rule sound:
    input:
        modes=results("panel/modes.nc"),
        rests=rests(
            *SOUND,
            study=section("sound"),
            highest=STUDY.response.frequency_hz[1],
            air_mass=STUDY.response.air_mass,
            code=code("sound"),
        ),
    output:
        SOUND,
    log:
        results("sound/sound.log"),
    shell:
        'python -m scripts.sound "$PIDPANEL_STUDY" {input.modes} {output}'
        " --made {input.rests} --to {output} 2> {log}"
