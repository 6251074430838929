# Pour packings, shake them loose, shake cases, gather them. Runs are kept once for all studies.


rule pour:
    output:
        "results/coupon/packing/{packing}/packing.json",
    log:
        "results/coupon/packing/{packing}.log",
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
    params:
        values=lambda wildcards: json.dumps(BEDS[wildcards.bed].as_dict()),
    shell:
        "python -m scripts.loosen {params.values:q} {input} {output} 2> {log}"


rule shake:
    input:
        lambda wildcards: [
            f"results/coupon/bed/{run.bed.label}/bed.json" for run in CASES[wildcards.case].runs
        ],
    output:
        "results/coupon/{case}/{target}.json",
    log:
        "results/coupon/{case}/{target}.log",
    wildcard_constraints:
        case=r"r[^/]+",
        target=r"[^/]+",
    params:
        runs=lambda wildcards: json.dumps([run.as_dict() for run in CASES[wildcards.case].runs]),
        target=lambda wildcards: json.dumps(vars(CASES[wildcards.case].target)),
    shell:
        "python -m scripts.shake {params.runs:q} {params.target:q} {output} {input} 2> {log}"


rule cases:
    input:
        outcomes_wanted,
    output:
        results("coupon/cases.csv"),
    log:
        results("coupon/cases.log"),
    params:
        file=STUDY_FILE,
        chosen=lambda wildcards: last_round() or "all",
        study=section("coupon"),
        code=code("coupon"),
    shell:
        "python -m scripts.cases {params.file} results/coupon {params.chosen} {output} 2> {log}"
