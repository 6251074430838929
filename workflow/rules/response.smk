# PSDs of every scenario; maps; files for other programs.

RESPONSE_SECTIONS = ("damping", "panel", "sound", "response")
# the choice of maps and coupled runs change no response to given damping
NOT_FOR_RESPONSE = {"response": {"maps"}, "damping": {"coupled"}}


rule response:
    input:
        modes=rules.panel.output.modes,
        plate=rules.panel.output.plate,
        section=rules.panel.output.section,
        modal_force=rules.sound.output.modal_force,
        air=rules.sound.output.air,
        surfaces=SURFACES,
        coupled=COUPLED,
    output:
        psd=results("response/psd.nc"),
        summary=results("response/summary.csv"),
        layouts=results("response/layouts.csv"),
        stress=results("response/stress.nc"),
        stress_table=results("response/stress.csv"),
        left_out=results("response/left_out.nc"),
    log:
        results("response/response.log"),
    benchmark:
        results("benchmark/response.tsv")
    threads: 2
    resources:
        mem_mb=2000,
    params:
        version=VERSION,
        damping=lambda wildcards: results("damping") if SURFACES else None,
        coupled=lambda wildcards: results("coupled") if COUPLED else None,
        study=section(*RESPONSE_SECTIONS, without=NOT_FOR_RESPONSE),
        dampers=used_dampers(),
        scenarios=scenarios(),
    message:
        "Response of the panel in all scenarios"
    script:
        "../scripts/response.py"


rule maps:
    input:
        modes=rules.panel.output.modes,
        plate=rules.panel.output.plate,
        modal_force=rules.sound.output.modal_force,
        air=rules.sound.output.air,
        left_out=rules.response.output.left_out,
        psd=rules.response.output.psd,
        coupled=rules.coupled.output.impedance if STUDY.is_coupled else [],
    output:
        maps=results("response/maps.nc"),
        folder=directory(results("response/maps")),
    log:
        results("response/maps.log"),
    benchmark:
        results("benchmark/maps.tsv")
    resources:
        mem_mb=2000,
    params:
        version=VERSION,
        study=section("panel", "sound", "response"),
        scenarios=scenarios(),
    message:
        "Maps of rms acceleration"
    script:
        "../scripts/maps.py"


rule export:
    input:
        modes=rules.panel.output.modes,
        psd=rules.response.output.psd,
        summary=rules.response.output.summary,
    output:
        folder=directory(results("response/export")),
    log:
        results("response/export.log"),
    benchmark:
        results("benchmark/export.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        damping_ratio=section("panel")["panel"]["damping_ratio"],
        scenarios=scenarios(),
    message:
        "Files for other programs"
    script:
        "../scripts/export.py"


REPORTED += [rules.response.output[key] for key in ("psd", "summary", "layouts", "stress_table")]
REPORTED += [rules.maps.output.maps]
