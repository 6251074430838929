# What is computed against what is known, stage by stage, and one page of it; of no study.

# a stage's cases are the keys of CASES in pidpanel.<stage>.verification
VERIFIED = {
    "coupon": ["collision", "sliding", "ball", "slug", "floor"],
    "panel": [
        "sandwich",
        "isotropic_core",
        "nafems_13",
        "nafems_21",
        "clamped_square",
        "free_square",
        "supported_disc",
        "clamped_disc",
    ],
    "sound": ["field"],
    "response": ["nafems_13r", "miles", "damper"],
}


rule verify:
    input:
        lambda wildcards: sorted((PROJECT / "templates").rglob("*.in.j2")),
    output:
        "results/verification/{stage}/{case}.csv",
    log:
        "results/verification/{stage}/{case}.log",
    params:
        code=lambda wildcards: code(wildcards.stage),
    shell:
        "python -m scripts.verify {wildcards.stage} {wildcards.case} {output} 2> {log}"


VERIFIED_ROWS = [
    f"results/verification/{stage}/{case}.csv"
    for stage, cases in VERIFIED.items()
    for case in cases
]


rule verification_page:
    input:
        rows=VERIFIED_ROWS,
        template=str(PROJECT / "templates/report/report.html.j2"),
    output:
        page="results/verification/verification.html",
        figures=directory("results/verification/figures"),
    log:
        "results/verification/verification.log",
    params:
        code=code("report", "verification.py"),
    shell:
        "python -m scripts.verification {output.page} {output.figures} {input.rows} 2> {log}"


# after the page, so that it tells of a number that is missed as well
rule verification:
    input:
        page="results/verification/verification.html",
        rows=VERIFIED_ROWS,
    output:
        "results/verification/verified.txt",
    log:
        "results/verification/verified.log",
    shell:
        "python -m scripts.verified {output} {input.rows} 2> {log}"
