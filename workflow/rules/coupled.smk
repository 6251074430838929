# Panel and particles in one time integration, for the reading `coupled`.

from pidpanel.coupled.from_study import coupled_runs

COUPLED_RUNS = {in_a_path(name): run for name, run in coupled_runs(STUDY).items()}
COUPLED_SCENARIOS = {in_a_path(run.scenario.label): run for run in COUPLED_RUNS.values()}
COUPLED_NAMES = ("summary.csv", "third_octaves.csv", "impedance.csv", "psd.csv")
COUPLED = [results(f"coupled/{name}") for name in COUPLED_NAMES]
# their beds are poured and shaken loose by the rules of the coupon
BEDS |= {bed.label: bed for run in COUPLED_RUNS.values() for bed in run.beds}
PACKINGS |= {bed.packing.label: bed.packing for bed in BEDS.values()}


rule coupled_run:
    input:
        modes=results("panel/modes.nc"),
        modal_force=results("sound/modal_force.nc"),
        plate=results("panel/plate.nc"),
        beds=beds_of_run,
        rests=rests(
            results("coupled/{scenario}/seed{seed}.nc"),
            values=lambda wildcards: coupled_digest(wildcards.scenario),
            decks=commands("coupled.in.j2", "header.j2", "contacts.j2"),
            code=code("coupled_run"),
        ),
    output:
        results("coupled/{scenario}/seed{seed}.nc"),
    log:
        results("coupled/{scenario}/seed{seed}.log"),
    # on a cluster a job whose time is over goes on from its last checkpoint
    retries: TRIED_AGAIN
    params:
        run=lambda wildcards: COUPLED_RUNS[f"{wildcards.scenario}/seed{wildcards.seed}"].name,
        # of its checkpoints, while it lasts
        folder=lambda wildcards, output: str(Path(output[0]).with_suffix("")),
    shell:
        'python -m scripts.coupled_run "$PIDPANEL_STUDY" {params.run:q}'
        " {input.modes} {input.modal_force} {input.plate} {params.folder:q} {output:q}"
        " {input.beds}"
        " --made {input.rests:q} --to {output:q} 2> {log:q}"


rule coupled:
    input:
        modes=results("panel/modes.nc"),
        modal_force=results("sound/modal_force.nc"),
        plate=results("panel/plate.nc"),
        records=[results(f"coupled/{name}.nc") for name in COUPLED_RUNS],
        rests=rests(
            *COUPLED,
            values=lambda wildcards: [coupled_digest(label) for label in COUPLED_SCENARIOS],
            code=code("coupled"),
        ),
    output:
        COUPLED,
    log:
        results("coupled/coupled.log"),
    shell:
        'python -m scripts.coupled "$PIDPANEL_STUDY" {input.modes} {input.modal_force}'
        " {input.plate} {output} {input.records:q}"
        " --made {input.rests} --to {output} 2> {log}"


rule verdict:
    input:
        psd=results("response/psd.nc"),
        summary=results("coupled/summary.csv"),
        bands=results("coupled/third_octaves.csv"),
        rests=rests(
            results("coupled/verdict.csv"),
            scenarios=lambda wildcards: SCENARIOS,
            readings=STUDY.readings,
            code=code("verdict"),
        ),
    output:
        results("coupled/verdict.csv"),
    log:
        results("coupled/verdict.log"),
    shell:
        'python -m scripts.verdict "$PIDPANEL_STUDY" {input.psd} {input.summary} {input.bands}'
        " {output} --made {input.rests} --to {output} 2> {log}"
