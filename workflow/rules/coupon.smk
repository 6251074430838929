# Pour packings, shake them loose, shake cases, gather them. Runs are kept once for all studies.
#
# docs/reruns.md lists what triggers a rerun: the labels of packings, beds and cases hold all that
# their numbers depend on, so only the judgement of runs has the code among its params.

# the coupons of a study share the runs; a case of two of them runs once, to the accuracy of both
COUPON_CASES = cases_by_coupon(STUDY)
DISTINCT_CASES = distinct(COUPON_CASES)
CASES = {case.label: case for cases in DISTINCT_CASES.values() for case in cases}
# no batch of two coupons: a change of one leaves the batches of the others as they are
for damper, cases in DISTINCT_CASES.items():
    alone = HAS_TARGET and damper == SECTION
    for batch in [Batch((case,)) for case in cases] if alone else batches_of(cases, JOB_SECONDS):
        add_batch(batch)
if HAS_ROUNDS:
    # where a job is a process of its own, it knows the rounds by what is there
    for number in itertools.count():
        file = Path(results(f"design/round{number}.json"))
        if not file.exists():
            break
        cases_of_round(file)


# judges what was run: other code judges it anew, and runs nothing that is there
SHAKE = code("shake")


wildcard_constraints:
    damper=NAME,
    leg=r"\d+",
    part=r"\d+",


rule pour:
    output:
        "results/coupon/packing/{packing}/packing.json",
    log:
        "results/coupon/packing/{packing}.log",
    priority: FIRST
    params:
        values=lambda wildcards: json.dumps(PACKINGS[wildcards.packing].as_dict()),
    shell:
        "python -m scripts.pour {params.values:q} {output} 2> {log}"


rule loosen:
    input:
        lambda wildcards: f"results/coupon/packing/{BEDS[wildcards.bed].packing.label}/packing.json",
    output:
        "results/coupon/bed/{bed}/bed.json",
    log:
        "results/coupon/bed/{bed}.log",
    priority: FIRST
    params:
        values=lambda wildcards: json.dumps(BEDS[wildcards.bed].as_dict()),
    shell:
        "python -m scripts.loosen {params.values:q} {input} {output} 2> {log}"


# runs of a long case, leg by leg; only where jobs have a time limit (`JOB_SECONDS`)
rule shake_leg:
    input:
        before=leg_of_part_before,
        beds=beds_of_part,
        rests=rests(
            "results/coupon/leg/{case}/{part}_{leg}.json",
            end=lambda wildcards: CASES[wildcards.case].outcome,
            runs=lambda wildcards: part_of(wildcards).runs,
        ),
    output:
        "results/coupon/leg/{case}/{part}_{leg}.json",
    log:
        "results/coupon/leg/{case}/{part}_{leg}.log",
    priority: cost_left
    retries: TRIED_AGAIN
    resources:
        runtime=lambda wildcards, attempt: job_minutes(cost_left(wildcards), attempt),
        mem_mb=lambda wildcards, attempt: attempt * memory_of(CASES[wildcards.case].runs[:1]),
    params:
        values=lambda wildcards: Batch((CASES[wildcards.case],)).as_text(),
        runs=lambda wildcards: ",".join(map(str, part_of(wildcards).runs)),
        before=lambda wildcards, input: input.before or "none",
        last=lambda wildcards: (int(int(wildcards.leg) + 1 == part_of(wildcards).legs)),
    shell:
        "python -m scripts.shake_leg {params.values:q} {params.runs} {params.before}"
        ' {params.last} results/coupon "$PIDPANEL_JOB_SECONDS" {output}'
        " --made {input.rests} --to {output} 2> {log}"


rule shake:
    input:
        beds=lambda wildcards: beds_of(BATCHES[wildcards.batch]),
        legs=lambda wildcards: last_legs(BATCHES[wildcards.batch]),
    output:
        "results/coupon/batch/{batch}.json",
    log:
        "results/coupon/batch/{batch}.log",
    priority: lambda wildcards: int(BATCHES[wildcards.batch].cost)
    retries: TRIED_AGAIN
    resources:
        runtime=lambda wildcards, attempt: job_minutes(BATCHES[wildcards.batch].cost, attempt),
        mem_mb=lambda wildcards, attempt: attempt
        * memory_of(run for case in BATCHES[wildcards.batch].cases for run in case.runs[:1]),
    params:
        values=lambda wildcards: BATCHES[wildcards.batch].as_text(),
        code=SHAKE,
    shell:
        "python -m scripts.shake {params.values:q} results/coupon {params.code}"
        ' "$PIDPANEL_JOB_SECONDS" {output} 2> {log}'


rule cases:
    input:
        outcomes=lambda wildcards: outcomes_wanted(SECTION),
        rests=rests(
            results("coupon/cases.csv"),
            study=lambda wildcards: coupon_digest(SECTION),
            code=code("cases"),
        ),
    output:
        results("coupon/cases.csv"),
    log:
        results("coupon/cases.log"),
    params:
        chosen=lambda wildcards: last_round() if HAS_ROUNDS else "none",
    shell:
        'python -m scripts.cases "$PIDPANEL_STUDY" coupon results/coupon {params.chosen} {output}'
        " --made {input.rests} --to {output} 2> {log}"


rule damper_cases:
    input:
        outcomes=lambda wildcards: outcomes_wanted(wildcards.damper),
        rests=rests(
            results("coupon/{damper}/cases.csv"),
            study=lambda wildcards: coupon_digest(wildcards.damper),
            code=code("cases"),
        ),
    output:
        results("coupon/{damper}/cases.csv"),
    log:
        results("coupon/{damper}/cases.log"),
    shell:
        'python -m scripts.cases "$PIDPANEL_STUDY" {wildcards.damper} results/coupon none {output}'
        " --made {input.rests} --to {output} 2> {log}"
