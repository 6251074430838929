# Layouts that are proposed within a mass budget.


rule optimise:
    input:
        modes=rules.panel.output.modes,
        plate=rules.panel.output.plate,
        section=rules.panel.output.section,
        modal_force=rules.sound.output.modal_force if STUDY.sound else [],
        air=rules.sound.output.air if STUDY.sound else [],
        surfaces=SURFACES,
    output:
        layouts=results("optimise/layouts.csv"),
        front=results("optimise/front.csv"),
        summary=results("optimise/summary.csv"),
        search=results("optimise/search.csv"),
        psd=results("optimise/psd.csv"),
    log:
        results("optimise/optimise.log"),
    benchmark:
        results("benchmark/optimise.tsv")
    threads: 2
    resources:
        mem_mb=2000,
    params:
        version=VERSION,
        damping=lambda wildcards: results("damping") if SURFACES else None,
        study=section(
            *("damping", "panel", "sound", "response", "base", "optimise"),
            without={"response": {"maps"}, "damping": {"coupled"}},
        ),
        dampers=used_dampers(),
    message:
        "Layouts within the mass budget"
    script:
        "../scripts/optimise.py"


REPORTED += list(rules.optimise.output)
