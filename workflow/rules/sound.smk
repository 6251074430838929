# The spectrum of the sound, the modal force of its field and, where it counts, the air's own.

SOUND = {
    "spectrum": results("sound/spectrum.csv"),
    "modal_force": results("sound/modal_force.nc"),
}
AIR = []
if {STUDY.response.radiation, STUDY.response.radiation_beside} != {"none"}:
    AIR = SOUND["air"] = results("sound/air.nc")


rule sound:
    input:
        modes=PANEL["modes"],
        request=request(
            *SOUND.values(),
            study=section("sound"),
            highest=STUDY.response.frequency_hz[1],
            air_mass=STUDY.response.air_mass,
        ),
    output:
        **SOUND,
    log:
        results("sound/sound.log"),
    benchmark:
        results("benchmark/sound.tsv")
    params:
        job=job(),
    message:
        "Modal forces of the sound"
    shell:
        "python -m scripts.sound {params.job:q} 2> {log}"
