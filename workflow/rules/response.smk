# Acceleration PSDs of every scenario in every reading of the damping.

SURFACE = [results("damping/surface.nc")] if "dem" in STUDY.damping.readings else []
BESIDE = [results("response/radiation.csv")] if STUDY.response.radiation_beside != "none" else []


rule response:
    input:
        modes=results("panel/modes.nc"),
        modal_force=results("sound/modal_force.nc"),
        surface=SURFACE,
        air=AIR,
        table=STUDY.damping.table or [],
    output:
        results("response/psd.nc"),
        results("response/summary.csv"),
        results("response/stress.nc"),
        results("response/stress.csv"),
        BESIDE,
    log:
        results("response/response.log"),
    params:
        file=STUDY_FILE,
        surface=SURFACE or "none",
        air=AIR or "none",
        study=section("damping", "panel", "sound", "response", "scenarios"),
        code=code("damping", "response"),
    shell:
        "python -m scripts.response {params.file} {input.modes} {input.modal_force}"
        " {params.surface} {params.air} {output} 2> {log}"
