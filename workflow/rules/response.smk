# PSDs of every scenario with every damping model; maps; files for other programs.

RESPONSE_SECTIONS = ("damping", "panel", "sound", "response")
# titles, the choice of maps and of cases, and coupled runs change no response to given damping
NOT_FOR_RESPONSE = {"response": {"maps"}, "damping": {"tones", "coupled"}}
SCENARIOS = text_digest(scenario.model_dump_json() for scenario in STUDY.all_scenarios())
SURFACES = [damper_file("damping", damper, "surface.nc") for damper in STUDY.surfaces]
# coupons come as surfaces
DAMPERS = values_digest(
    {
        damper: STUDY.all_dampers[damper].model_dump(exclude={"coupon"})
        for damper in STUDY.used_dampers
    }
)
RESPONSE = {
    "psd": results("response/psd.nc"),
    "summary": results("response/summary.csv"),
    "layouts": results("response/layouts.csv"),
    "stress": results("response/stress.nc"),
    "stress_table": results("response/stress.csv"),
    "left_out": results("response/left_out.nc"),
}
if STUDY.response.radiation_beside != "none":
    RESPONSE["radiation"] = results("response/radiation.csv")
RESPONSE_FOLDERS = {}
if SURFACES:
    RESPONSE_FOLDERS["damping"] = results("damping")
if STUDY.is_coupled:
    RESPONSE_FOLDERS["coupled"] = results("coupled")
MAPS = results("response/maps.nc")
MAPS_FOLDER, EXPORT = results("response/maps"), results("response/export")


rule response:
    input:
        modes=PANEL["modes"],
        modal_force=SOUND["modal_force"],
        plate=PANEL["plate"],
        section=PANEL["section"],
        surfaces=SURFACES,
        air=AIR,
        coupled=list(COUPLED.values()) if STUDY.is_coupled else [],
        request=request(
            *RESPONSE.values(),
            study=section(*RESPONSE_SECTIONS, without=NOT_FOR_RESPONSE),
            dampers=DAMPERS,
            scenarios=SCENARIOS,
        ),
    output:
        **RESPONSE,
    log:
        results("response/response.log"),
    benchmark:
        results("benchmark/response.tsv")
    params:
        job=job(**RESPONSE_FOLDERS),
    message:
        "Response of the panel in all scenarios"
    shell:
        "python -m scripts.response {params.job:q} 2> {log}"


rule maps:
    input:
        modes=PANEL["modes"],
        modal_force=SOUND["modal_force"],
        air=AIR,
        plate=PANEL["plate"],
        left_out=RESPONSE["left_out"],
        psd=RESPONSE["psd"],
        coupled=COUPLED["impedance"] if STUDY.is_coupled else [],
        request=request(
            MAPS,
            MAPS_FOLDER,
            study=section("panel", "sound", "response"),
            scenarios=SCENARIOS,
        ),
    output:
        maps=MAPS,
        folder=directory(MAPS_FOLDER),
    log:
        results("response/maps.log"),
    benchmark:
        results("benchmark/maps.tsv")
    params:
        job=job(),
    message:
        "Maps of rms acceleration"
    shell:
        "python -m scripts.maps {params.job:q} 2> {log}"


rule export:
    input:
        modes=PANEL["modes"],
        psd=RESPONSE["psd"],
        summary=RESPONSE["summary"],
        request=request(
            EXPORT,
            readings=STUDY.readings,
            damping_ratio=STUDY.panel.damping_ratio,
            scenarios=SCENARIOS,
        ),
    output:
        folder=directory(EXPORT),
    log:
        results("response/export.log"),
    benchmark:
        results("benchmark/export.tsv")
    params:
        job=job(),
    message:
        "Files for other programs"
    shell:
        "python -m scripts.export {params.job:q} 2> {log}"
