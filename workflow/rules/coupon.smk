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
        lambda wildcards: beds_of(BATCHES[wildcards.batch]),
    output:
        "results/coupon/batch/{batch}.json",
    log:
        "results/coupon/batch/{batch}.log",
    params:
        values=lambda wildcards: json.dumps(BATCHES[wildcards.batch].as_list()),
    shell:
        "python -m scripts.shake {params.values:q} results/coupon {output} 2> {log}"


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
