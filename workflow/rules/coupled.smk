# Panel and particles in one time integration, for dampers with `model: coupled`.

from pidpanel.coupled.from_study import coupled_scenarios, depends_on

COUPLED_SCENARIOS = {in_a_path(label): s for label, s in coupled_scenarios(STUDY).items()}
# beds of the first run of each; further runs make their own
FIRST_BEDS = {label: list(s.beds[0]) for label, s in COUPLED_SCENARIOS.items()}
add_beds(bed for beds in FIRST_BEDS.values() for bed in beds)


rule coupled_scenario:
    input:
        modes=rules.panel.output.modes,
        plate=rules.panel.output.plate,
        modal_force=rules.sound.output.modal_force if STUDY.sound else [],
        air=rules.sound.output.air if STUDY.sound else [],
        beds=lambda wildcards: expand(
            rules.loosen.output.bed, bed=[bed.label for bed in FIRST_BEDS[wildcards.scenario]]
        ),
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
        runtime=int(JOB_MINUTES) + 5 if JOB_MINUTES else 1440,
    params:
        version=VERSION,
        scenario=lambda wildcards: COUPLED_SCENARIOS[wildcards.scenario].name,
        values=lambda wildcards: by_content(
            depends_on(STUDY, COUPLED_SCENARIOS[wildcards.scenario].name)
        ),
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
