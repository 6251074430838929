# PSDs of every scenario in every reading of the damping; maps; files for other programs.

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


rule maps:
    input:
        modes=results("panel/modes.nc"),
        modal_force=results("sound/modal_force.nc"),
        air=AIR,
        psd=results("response/psd.nc"),
    output:
        results("response/maps.nc"),
        directory(results("response/maps")),
    log:
        results("response/maps.log"),
    params:
        file=STUDY_FILE,
        air=AIR or "none",
        study=section("damping", "panel", "sound", "response", "scenarios"),
        code=code("response"),
    shell:
        "python -m scripts.maps {params.file} {input.modes} {input.modal_force} {params.air}"
        " {input.psd} {output} 2> {log}"


rule export:
    input:
        results("response/psd.nc"),
    output:
        directory(results("response/export")),
    log:
        results("response/export.log"),
    params:
        file=STUDY_FILE,
        study=section("damping", "scenarios"),
        code=code("response/export.py", "response/bands.py"),
    shell:
        "python -m scripts.export {params.file} {input} {output} 2> {log}"
