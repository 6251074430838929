# Pour packings, shake them loose, shake cases, gather them. Runs are kept once for all studies.
#
# docs/reruns.md lists what triggers a rerun: the labels of packings, beds and cases hold all that
# their numbers depend on.

# before all else that waits
FIRST = 10**6


rule pour:
    input:
        values=lambda wildcards: RUNS.packing(wildcards.packing),
    output:
        packing="results/coupon/packing/{packing}/packing.json",
    log:
        "results/coupon/packing/{packing}.log",
    benchmark:
        "results/coupon/benchmark/packing/{packing}.tsv"
    priority: FIRST
    params:
        job=job(),
    message:
        "Pour packing {wildcards.packing}"
    shell:
        "python -m scripts.pour {params.job:q} 2> {log}"


rule loosen:
    input:
        values=lambda wildcards: RUNS.bed(wildcards.bed),
        packing=lambda wildcards: RUNS.packing_of(wildcards.bed),
    output:
        bed="results/coupon/bed/{bed}/bed.json",
    log:
        "results/coupon/bed/{bed}.log",
    benchmark:
        "results/coupon/benchmark/bed/{bed}.tsv"
    priority: FIRST
    params:
        job=job(),
    message:
        "Shake bed {wildcards.bed} loose"
    shell:
        "python -m scripts.loosen {params.job:q} 2> {log}"


# runs of a long case, leg by leg; only where jobs have a time limit (`job_minutes`)
rule shake_leg:
    input:
        before=lambda w: RUNS.leg_before(w.case, int(w.part), int(w.leg)),
        beds=lambda w: RUNS.beds_of_part(w.case, int(w.part)),
        request=lambda w: RUNS.leg(w.case, int(w.part), int(w.leg)),
    output:
        leg="results/coupon/leg/{case}/{part}_{leg}.json",
    log:
        "results/coupon/leg/{case}/{part}_{leg}.log",
    benchmark:
        "results/coupon/benchmark/leg/{case}/{part}_{leg}.tsv"
    priority: lambda w: RUNS.cost_from_leg(w.case, int(w.part), int(w.leg))
    retries: RUNS.retries
    resources:
        runtime=lambda w, attempt: RUNS.job_minutes(
            RUNS.cost_from_leg(w.case, int(w.part), int(w.leg)), attempt
        ),
        mem_mb=lambda w, attempt: RUNS.memory_of_case(w.case, attempt),
    params:
        job=job(),
    message:
        "Shake case {wildcards.case}, part {wildcards.part}, leg {wildcards.leg}"
    shell:
        "python -m scripts.shake_leg {params.job:q} 2> {log}"


rule shake:
    input:
        batch=lambda wildcards: RUNS.batch(wildcards.batch),
        beds=lambda wildcards: RUNS.beds_of_batch(wildcards.batch),
        legs=lambda wildcards: RUNS.legs_of_batch(wildcards.batch),
    output:
        batch="results/coupon/batch/{batch}.json",
    log:
        "results/coupon/batch/{batch}.log",
    benchmark:
        "results/coupon/benchmark/batch/{batch}.tsv"
    priority: lambda wildcards: RUNS.cost_of_batch(wildcards.batch)
    retries: RUNS.retries
    resources:
        runtime=lambda wildcards, attempt: RUNS.job_minutes(
            RUNS.cost_of_batch(wildcards.batch), attempt
        ),
        mem_mb=lambda wildcards, attempt: RUNS.memory_of_batch(wildcards.batch, attempt),
    params:
        job=job(),
    message:
        "Shake batch {wildcards.batch}"
    shell:
        "python -m scripts.shake {params.job:q} 2> {log}"


rule cases:
    input:
        outcomes=lambda wildcards: RUNS.outcomes(RUNS.swept(SECTION)),
        request=request(results("coupon/cases.csv"), study=lambda wildcards: PLAN.coupon()),
    output:
        cases=results("coupon/cases.csv"),
    log:
        results("coupon/cases.log"),
    benchmark:
        results("benchmark/cases.tsv")
    params:
        job=job(damper=SECTION),
    message:
        "Gather the cases of the coupon"
    shell:
        "python -m scripts.cases {params.job:q} 2> {log}"


rule damper_cases:
    input:
        outcomes=lambda wildcards: RUNS.outcomes(RUNS.swept(wildcards.damper)),
        request=request(
            results("coupon/{damper}/cases.csv"),
            study=lambda wildcards: PLAN.coupon(wildcards.damper),
        ),
    output:
        cases=results("coupon/{damper}/cases.csv"),
    log:
        results("coupon/{damper}/cases.log"),
    benchmark:
        results("benchmark/cases_{damper}.tsv")
    params:
        job=job(damper=lambda wildcards: wildcards.damper),
    message:
        "Gather the cases of damper {wildcards.damper}"
    shell:
        "python -m scripts.cases {params.job:q} 2> {log}"


# only on request: results/<study>/coupon/atlas.csv; see docs/atlas.md
rule atlas:
    input:
        cases=results("coupon/cases.csv"),
        request=request(results("coupon/atlas.csv"), study=lambda wildcards: PLAN.coupon()),
    output:
        atlas=results("coupon/atlas.csv"),
    log:
        results("coupon/atlas.log"),
    params:
        job=job(),
    message:
        "Write the cases of the coupon as rows of the atlas"
    shell:
        "python -m scripts.atlas {params.job:q} 2> {log}"
