# Pour packings, shake them loose, shake cases, gather them. Runs are kept once for all studies.


rule pour:
    output:
        "results/coupon/packing/{packing}/packing.json",
    params:
        values=lambda wildcards: json.dumps(vars(PACKINGS[wildcards.packing])),
    log:
        "results/coupon/packing/{packing}.log",
    shell:
        "python -m scripts.pour {params.values:q} {output} 2> {log}"


rule loosen:
    input:
        lambda wildcards: f"results/coupon/packing/{BEDS[wildcards.bed].packing.label}/packing.json",
    output:
        "results/coupon/bed/{bed}/bed.json",
    params:
        values=lambda wildcards: json.dumps(BEDS[wildcards.bed].as_dict()),
    log:
        "results/coupon/bed/{bed}.log",
    shell:
        "python -m scripts.loosen {params.values:q} {input} {output} 2> {log}"


rule shake:
    input:
        lambda wildcards: f"results/coupon/bed/{run_of(wildcards).bed.label}/bed.json",
    output:
        "results/coupon/{case}/s{seed}/run.json",
    params:
        values=lambda wildcards: json.dumps(run_of(wildcards).as_dict()),
    log:
        "results/coupon/{case}/s{seed}.log",
    shell:
        "python -m scripts.shake {params.values:q} {input} {output} 2> {log}"


rule cases:
    input:
        [
            f"results/coupon/{label}/s{run.packing.seed}/run.json"
            for label, case in CASES.items()
            for run in case.runs
        ],
    output:
        results("coupon/cases.csv"),
    params:
        file=STUDY_FILE,
        study=section("coupon"),
        code=code("coupon"),
    log:
        results("coupon/cases.log"),
    shell:
        "python -m scripts.cases {params.file} results/coupon {output} 2> {log}"
