# PSDs of every scenario in every reading of the damping; maps; files for other programs.

SURFACES = [coupon_file("damping", damper, "surface.nc") for damper in STUDY.surfaces]
RESPONSE_SECTIONS = ("damping", "panel", "sound", "response")
# titles, the choice of maps and of cases, and coupled runs change no response to given damping
NOT_FOR_RESPONSE = {"response": {"maps"}, "damping": {"target", "tones", "coupled"}}
SCENARIOS = text_digest(scenario.model_dump_json() for scenario in STUDY.all_scenarios())
# coupons come as surfaces
DAMPERS = values_digest(
    {
        damper: STUDY.all_dampers[damper].model_dump(exclude={"coupon"})
        for damper in STUDY.used_dampers
    }
)
BESIDE = [results("response/radiation.csv")] if STUDY.response.radiation_beside != "none" else []
RESPONSE_NAMES = ("psd.nc", "summary.csv", "layouts.csv", "stress.nc", "stress.csv", "left_out.nc")
RESPONSE = [*(results(f"response/{name}") for name in RESPONSE_NAMES), *BESIDE]
MAPS, MAPS_FOLDER = results("response/maps.nc"), results("response/maps")
EXPORT = results("response/export")


rule response:
    input:
        modes=results("panel/modes.nc"),
        modal_force=results("sound/modal_force.nc"),
        plate=results("panel/plate.nc"),
        section=results("panel/section.csv"),
        surfaces=SURFACES,
        air=AIR,
        coupled=COUPLED if STUDY.is_coupled else [],
        rests=rests(
            *RESPONSE,
            study=section(*RESPONSE_SECTIONS, without=NOT_FOR_RESPONSE),
            dampers=DAMPERS,
            scenarios=SCENARIOS,
            code=code("response"),
        ),
    output:
        RESPONSE,
    log:
        results("response/response.log"),
    params:
        damping=lambda wildcards, input: results("damping") if input.surfaces else "none",
        air=AIR or "none",
        coupled=results("coupled") if STUDY.is_coupled else "none",
    shell:
        'python -m scripts.response "$PIDPANEL_STUDY" {input.modes} {input.modal_force}'
        " {input.plate} {input.section} {params.damping} {params.air}"
        " {params.coupled} {output} --made {input.rests} --to {output} 2> {log}"


rule maps:
    input:
        modes=results("panel/modes.nc"),
        modal_force=results("sound/modal_force.nc"),
        air=AIR,
        plate=results("panel/plate.nc"),
        left_out=results("response/left_out.nc"),
        psd=results("response/psd.nc"),
        coupled=results("coupled/impedance.csv") if STUDY.is_coupled else [],
        rests=rests(
            MAPS,
            MAPS_FOLDER,
            study=section("panel", "sound", "response"),
            scenarios=SCENARIOS,
            code=code("maps"),
        ),
    output:
        MAPS,
        directory(MAPS_FOLDER),
    log:
        results("response/maps.log"),
    params:
        air=AIR or "none",
        coupled=lambda wildcards, input: input.coupled or "none",
    shell:
        'python -m scripts.maps "$PIDPANEL_STUDY" {input.modes} {input.modal_force} {params.air}'
        " {input.plate} {input.left_out} {input.psd} {params.coupled} {output}"
        " --made {input.rests} --to {output} 2> {log}"


rule export:
    input:
        modes=results("panel/modes.nc"),
        psd=results("response/psd.nc"),
        summary=results("response/summary.csv"),
        rests=rests(
            EXPORT,
            readings=STUDY.readings,
            damping_ratio=STUDY.panel.damping_ratio,
            scenarios=SCENARIOS,
            code=code("export"),
        ),
    output:
        directory(EXPORT),
    log:
        results("response/export.log"),
    shell:
        'python -m scripts.export "$PIDPANEL_STUDY" {input.modes} {input.psd}'
        " {input.summary} {output} --made {input.rests} --to {output} 2> {log}"
