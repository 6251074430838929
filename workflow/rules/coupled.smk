# Panel and particles in one time integration, for the damping model `coupled`.

from pidpanel.coupled.from_study import coupled_scenarios, depends_on

COUPLED_SCENARIOS = {in_a_path(label): s for label, s in coupled_scenarios(STUDY).items()}
COUPLED = coupled_files(PLAN)
# rules of the coupon prepare the beds of the first runs; further runs prepare their own
RUNS.add_beds(bed for scenario in COUPLED_SCENARIOS.values() for bed in scenario.beds[0])


def coupled_values(label):
    """What the study says of the runs of a scenario."""
    return values_digest(depends_on(STUDY, COUPLED_SCENARIOS[label].name))


rule coupled_scenario:
    input:
        modes=PANEL["modes"],
        modal_force=FORCE,
        plate=PANEL["plate"],
        air=AIR,
        beds=lambda wildcards: bed_files(COUPLED_SCENARIOS[wildcards.scenario].beds[0]),
        request=request(
            results("coupled/{scenario}.nc"),
            values=lambda wildcards: coupled_values(wildcards.scenario),
        ),
    output:
        estimate=results("coupled/{scenario}.nc"),
    log:
        results("coupled/{scenario}.log"),
    benchmark:
        results("benchmark/coupled_{scenario}.tsv")
    # on a cluster a job whose time is over continues from its last checkpoint
    retries: RUNS.retries
    params:
        job=job(
            scenario=lambda wildcards: COUPLED_SCENARIOS[wildcards.scenario].name,
            folder=lambda wildcards: results(f"coupled/{wildcards.scenario}"),
        ),
    message:
        "Panel and particles together, {wildcards.scenario}"
    shell:
        "python -m scripts.coupled_scenario {params.job:q} 2> {log:q}"


rule coupled:
    input:
        estimates=[results(f"coupled/{name}.nc") for name in COUPLED_SCENARIOS],
        request=request(
            *COUPLED.values(),
            values=lambda wildcards: [coupled_values(label) for label in COUPLED_SCENARIOS],
            scenarios=lambda wildcards: SCENARIOS,
        ),
    output:
        **COUPLED,
    log:
        results("coupled.log"),
    benchmark:
        results("benchmark/coupled.tsv")
    params:
        job=job(),
    message:
        "Tables of the coupled runs"
    shell:
        "python -m scripts.coupled {params.job:q} 2> {log}"


if STUDY.sound is not None:

    rule verdict:
        input:
            psd=results("response/psd.nc"),
            summary=COUPLED["summary"],
            third_octaves=COUPLED["third_octaves"],
            request=request(
                results("coupled/verdict.csv"),
                scenarios=lambda wildcards: SCENARIOS,
                readings=STUDY.readings,
            ),
        output:
            verdict=results("coupled/verdict.csv"),
        log:
            results("verdict.log"),
        benchmark:
            results("benchmark/verdict.tsv")
        params:
            job=job(),
        message:
            "Damping models against the coupled runs"
        shell:
            "python -m scripts.verdict {params.job:q} 2> {log}"
