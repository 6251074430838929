# Statistical energy above the frequencies of the response.


rule energy:
    input:
        modes=rules.panel.output.modes,
        plate=rules.panel.output.plate,
        modal_force=rules.sound.output.modal_force,
        air=rules.sound.output.air,
        surfaces=SURFACES,
        coupled=COUPLED,
        psd=rules.response.output.psd,
        summary=rules.response.output.summary,
        layouts=rules.response.output.layouts,
        left_out=rules.response.output.left_out,
    output:
        bands=results("energy/bands.csv"),
        psd=results("energy/psd.nc"),
        summary=results("energy/summary.csv"),
    log:
        results("energy/energy.log"),
    benchmark:
        results("benchmark/energy.tsv")
    resources:
        mem_mb=2000,
    params:
        version=VERSION,
        damping=lambda wildcards: results("damping") if SURFACES else None,
        coupled=lambda wildcards: results("coupled") if COUPLED else None,
        study=section(*RESPONSE_SECTIONS, "energy", without=NOT_FOR_RESPONSE),
        dampers=used_dampers(),
        scenarios=scenarios(),
    message:
        "Statistical energy of the panel"
    script:
        "../scripts/energy.py"


REPORTED += list(rules.energy.output)
