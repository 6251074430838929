# Panel and particles in one time integration, for the damping model `coupled`.

from pidpanel.coupled.from_study import coupled_scenarios, depends_on

COUPLED_SCENARIOS = {in_a_path(label): s for label, s in coupled_scenarios(STUDY).items()}


def first_beds(label):
    """Beds of the first run of a scenario; further runs make their own."""
    return {bed.label: bed for bed in COUPLED_SCENARIOS[label].beds[0]}


for label in COUPLED_SCENARIOS:
    BEDS.update(first_beds(label))


def coupled_values(label):
    """What the runs of a scenario depend on in the study."""
    return by_content(depends_on(STUDY, COUPLED_SCENARIOS[label].name))


rule coupled_scenario:
    input:
        modes=rules.panel.output.modes,
        plate=rules.panel.output.plate,
        modal_force=rules.sound.output.modal_force if STUDY.sound else [],
        air=rules.sound.output.air if STUDY.sound else [],
        beds=lambda wildcards: expand(rules.loosen.output.bed, bed=first_beds(wildcards.scenario)),
    output:
        estimate=results("coupled/{scenario}.nc"),
    log:
        results("coupled/{scenario}.log"),
    benchmark:
        results("benchmark/coupled_{scenario}.tsv")
    # on a cluster a job whose time is over continues from its last checkpoint
    retries: RETRIES
    resources:
        mem_mb=2000,
        runtime=JOB_MINUTES or 1440,
    params:
        version=VERSION,
        scenario=lambda wildcards: COUPLED_SCENARIOS[wildcards.scenario].name,
        values=lambda wildcards: coupled_values(wildcards.scenario),
        folder=lambda wildcards: results(f"coupled/{wildcards.scenario}"),
    message:
        "Panel and particles together, {wildcards.scenario}"
    script:
        "../scripts/coupled_scenario.py"


rule coupled:
    input:
        estimates=expand(rules.coupled_scenario.output.estimate, scenario=COUPLED_SCENARIOS),
    output:
        summary=results("coupled/summary.csv"),
        third_octaves=results("coupled/third_octaves.csv"),
        impedance=results("coupled/impedance.csv"),
        psd=results("coupled/psd.csv"),
    log:
        results("coupled.log"),
    benchmark:
        results("benchmark/coupled.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        scenarios=scenarios(),
    message:
        "Tables of the coupled runs"
    script:
        "../scripts/coupled.py"


REPORTED += [rules.coupled.output.summary, rules.coupled.output.impedance]
