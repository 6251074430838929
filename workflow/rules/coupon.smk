# Pour packings, shake them loose, shake cases, gather them. Runs are kept once for all studies.
#
# The labels of packings, beds and cases hold all that their numbers depend on (docs/reruns.md).

from pidpanel.coupon.estimate import case_seconds, run_memory
from pidpanel.coupon.from_study import cases_by_coupon
from pidpanel.coupon.attempts import JUDGING_VERSION

# by damper and label; a case of two dampers is one
SWEPT = cases_by_coupon(STUDY)
CASES = {label: case for cases in SWEPT.values() for label, case in cases.items()}
add_beds(run.bed for case in CASES.values() for run in case.runs)

# with a time limit of jobs, one that is over goes on from its last restart
JOB_MINUTES = float(config.get("job_minutes", 0))
RETRIES = 50 if JOB_MINUTES else None
# before all else that waits
FIRST = 10**6


rule pour:
    output:
        packing="results/coupon/packing/{packing}/packing.json",
    log:
        "results/coupon/packing/{packing}.log",
    benchmark:
        "results/coupon/benchmark/packing/{packing}.tsv"
    priority: FIRST
    resources:
        mem_mb=500,
    params:
        packing=lambda wildcards: PACKINGS[wildcards.packing],
    message:
        "Pour packing {wildcards.packing}"
    script:
        "../scripts/pour.py"


rule loosen:
    input:
        packing=lambda wildcards: rules.pour.output.packing.format(
            packing=BEDS[wildcards.bed].packing.label
        ),
    output:
        bed="results/coupon/bed/{bed}/bed.json",
    log:
        "results/coupon/bed/{bed}.log",
    benchmark:
        "results/coupon/benchmark/bed/{bed}.tsv"
    priority: FIRST
    resources:
        mem_mb=500,
    params:
        bed=lambda wildcards: BEDS[wildcards.bed],
    message:
        "Shake bed {wildcards.bed} loose"
    script:
        "../scripts/loosen.py"


# the seeds of a case; `target` is the accuracy at which its runs end
rule shake:
    input:
        beds=lambda wildcards: expand(
            rules.loosen.output.bed, bed=[run.bed.label for run in CASES[wildcards.case].runs]
        ),
    output:
        outcome="results/coupon/{case}/{target}.json",
    log:
        "results/coupon/{case}/{target}.log",
    benchmark:
        "results/coupon/benchmark/{case}/{target}.tsv"
    wildcard_constraints:
        target="[^/]+_[0-9]+to[^/]+",
    priority: lambda wildcards: int(case_seconds(CASES[wildcards.case]))
    retries: RETRIES
    resources:
        mem_mb=lambda wildcards, attempt: attempt
        * int(run_memory(CASES[wildcards.case].point) / 1e6),
        runtime=lambda wildcards, attempt: attempt
        * int(5 + min(JOB_MINUTES or 1440, case_seconds(CASES[wildcards.case]) / 30)),
    params:
        case=lambda wildcards: CASES[wildcards.case],
        judging=JUDGING_VERSION,
    message:
        "Shake case {wildcards.case}"
    script:
        "../scripts/shake.py"


rule cases:
    input:
        outcomes=outcomes,
    output:
        cases=results(f"coupon/{DAMPER}cases.csv"),
    log:
        results(f"coupon/{DAMPER}cases.log"),
    benchmark:
        results(f"benchmark/{DAMPER}cases.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        damper=damper_of,
        coupon=coupon,
    message:
        "Gather the cases of {params.damper}"
    script:
        "../scripts/cases.py"


# only on request: results/<study>/coupon/atlas.csv; see docs/atlas.md
rule atlas:
    input:
        cases=rules.cases.output.cases,
    output:
        atlas=results("coupon/atlas.csv"),
    log:
        results("coupon/atlas.log"),
    benchmark:
        results("benchmark/atlas.tsv")
    resources:
        mem_mb=500,
    params:
        version=VERSION,
        coupon=coupon,
    message:
        "Write the cases of the coupon as rows of the atlas"
    script:
        "../scripts/atlas.py"
