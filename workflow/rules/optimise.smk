# Layouts that are proposed within a mass budget.

PROPOSAL = {
    name: results(f"optimise/{name}.csv") for name in ("layouts", "front", "summary", "search")
}


rule optimise:
    input:
        modes=PANEL["modes"],
        modal_force=SOUND["modal_force"],
        plate=PANEL["plate"],
        surfaces=SURFACES,
        air=AIR,
        request=request(
            *PROPOSAL.values(),
            study=section("damping", "panel", "sound", "response", "dampers", "optimise"),
        ),
    output:
        **PROPOSAL,
    log:
        results("optimise/optimise.log"),
    benchmark:
        results("benchmark/optimise.tsv")
    threads: 2
    params:
        job=job(**{key: value for key, value in RESPONSE_FOLDERS.items() if key == "damping"}),
    message:
        "Layouts within the mass budget"
    shell:
        "python -m scripts.optimise {params.job:q} 2> {log}"
