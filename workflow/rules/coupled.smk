# Panel and particles in one time integration, for the reading `coupled`.

from pidpanel.coupled.from_study import coupled_scenarios

COUPLED_SCENARIOS = {in_a_path(label): one for label, one in coupled_scenarios(STUDY).items()}
COUPLED_NAMES = ("summary.csv", "third_octaves.csv", "impedance.csv", "psd.csv")
COUPLED = [results(f"coupled/{name}") for name in COUPLED_NAMES]
# the beds of the first runs are poured and shaken loose by the rules of the coupon, those of
# further runs where they are wanted
BEDS |= {bed.label: bed for one in COUPLED_SCENARIOS.values() for bed in one.beds[0]}
PACKINGS |= {bed.packing.label: bed.packing for bed in BEDS.values()}


wildcard_constraints:
    scenario="[^/]+",


rule coupled_scenario:
    input:
        modes=results("panel/modes.nc"),
        modal_force=results("sound/modal_force.nc"),
        plate=results("panel/plate.nc"),
        air=AIR,
        beds=lambda wildcards: [
            f"results/coupon/bed/{bed.label}/bed.json"
            for bed in COUPLED_SCENARIOS[wildcards.scenario].beds[0]
        ],
        rests=rests(
            results("coupled/{scenario}.nc"),
            values=lambda wildcards: coupled_digest(wildcards.scenario),
            decks=commands("coupled.in.j2", "header.j2", "contacts.j2"),
            code=code("coupled_scenario"),
        ),
    output:
        results("coupled/{scenario}.nc"),
    log:
        results("coupled/{scenario}.log"),
    # on a cluster a job whose time is over goes on from its last checkpoint
    retries: TRIED_AGAIN
    params:
        label=lambda wildcards: COUPLED_SCENARIOS[wildcards.scenario].name,
        air=AIR or "none",
        folder=lambda wildcards, output: str(Path(output[0]).with_suffix("")),
    shell:
        'python -m scripts.coupled_scenario "$PIDPANEL_STUDY" {params.label:q}'
        " {input.modes} {input.modal_force} {input.plate} {params.air} results/coupon"
        " {params.folder:q} {output:q}"
        " --made {input.rests:q} --to {output:q} 2> {log:q}"


rule coupled:
    input:
        modes=results("panel/modes.nc"),
        modal_force=results("sound/modal_force.nc"),
        plate=results("panel/plate.nc"),
        air=AIR,
        estimates=[results(f"coupled/{name}.nc") for name in COUPLED_SCENARIOS],
        rests=rests(
            *COUPLED,
            values=lambda wildcards: [coupled_digest(label) for label in COUPLED_SCENARIOS],
            scenarios=lambda wildcards: SCENARIOS,
            code=code("coupled"),
        ),
    output:
        COUPLED,
    log:
        results("coupled.log"),
    params:
        air=AIR or "none",
    shell:
        'python -m scripts.coupled "$PIDPANEL_STUDY" {input.modes} {input.modal_force}'
        " {input.plate} {params.air} {output} {input.estimates:q}"
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
        results("verdict.log"),
    shell:
        'python -m scripts.verdict "$PIDPANEL_STUDY" {input.psd} {input.summary} {input.bands}'
        " {output} --made {input.rests} --to {output} 2> {log}"
