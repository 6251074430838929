# Computed values against closed forms and published solutions, stage by stage, and their page;
# independent of any study.

# a stage's cases are the keys of CASES in pidpanel.verification.<stage>
VERIFIED = {
    "coupon": [
        "collision",
        "sliding",
        "rolling",
        "oblique",
        "peak",
        "growth",
        "ball",
        "slug",
        "floor",
    ],
    "panel": [
        "sandwich",
        "nafems_13",
        "nafems_21",
        "clamped_square",
        "free_square",
        "supported_disc",
        "clamped_disc",
        "turned",
        "stretched",
    ],
    "sound": ["field", "disc", "reciprocity", "rectangle", "wall"],
    "response": ["nafems_13r", "miles", "layouts", "power", "duffing", "stretching"],
    "base": ["oscillator", "supported_plate", "limits", "balance"],
}
# shown beside measurements of others, without a verdict
VALIDATED = ["impact", "lammps", "open_bed", "box", "periods"]


rule verify:
    output:
        rows="results/verification/{stage}/{case}.csv",
    log:
        "results/verification/{stage}/{case}.log",
    benchmark:
        "results/verification/benchmark/{stage}_{case}.tsv"
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
    message:
        "Verify {wildcards.stage}, {wildcards.case}"
    script:
        "../scripts/verify.py"


VERIFIED_ROWS = [
    f"results/verification/{stage}/{case}.csv"
    for stage, cases in VERIFIED.items()
    for case in cases
]


rule verification_page:
    input:
        rows=VERIFIED_ROWS,
    output:
        page="results/verification/verification.html",
    log:
        "results/verification/verification.log",
    benchmark:
        "results/verification/benchmark/page.tsv"
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
    message:
        "Page of the verification"
    script:
        "../scripts/verification.py"


# after the page, so that the page shows a number outside its tolerance as well
rule verification:
    input:
        page="results/verification/verification.html",
        rows=VERIFIED_ROWS,
    output:
        verdict="results/verification/verified.txt",
    log:
        "results/verification/verified.log",
    benchmark:
        "results/verification/benchmark/verified.tsv"
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
    message:
        "Compare the verification with its tolerances"
    script:
        "../scripts/verified.py"


rule validation:
    input:
        rows=expand("results/verification/experiments/{case}.csv", case=VALIDATED),
    output:
        page="results/validation/validation.html",
    log:
        "results/validation/validation.log",
    benchmark:
        "results/validation/benchmark/page.tsv"
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
    message:
        "Page of the validation"
    script:
        "../scripts/validation.py"
