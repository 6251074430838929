# Computed values against closed forms and published solutions, stage by stage, and their page;
# independent of any study.

# a stage's cases are the keys of CASES in pidpanel.verification.<stage>
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
        "turned",
        "mesh_file",
    ],
    "sound": ["field"],
    "response": [
        "nafems_13r",
        "miles",
        "damper",
        "equal",
        "heavy",
        "together",
        "everywhere",
    ],
}


DECKS = sorted(
    str(path) for path in TEMPLATES.rglob("*.j2") if path.parent.name not in ("report", "study")
)


rule verify:
    input:
        rests=rests(
            "results/verification/{stage}/{case}.csv",
            decks=commands(*DECKS),
            code=lambda wildcards: digest_of_code(
                "scripts.verify", f"pidpanel.verification.{wildcards.stage}"
            ),
        ),
    output:
        "results/verification/{stage}/{case}.csv",
    log:
        "results/verification/{stage}/{case}.log",
    shell:
        "python -m scripts.verify {wildcards.stage} {wildcards.case} {output}"
        " --made {input.rests} --to {output} 2> {log}"


VERIFIED_ROWS = [
    f"results/verification/{stage}/{case}.csv"
    for stage, cases in VERIFIED.items()
    for case in cases
]


rule verification_page:
    input:
        rows=VERIFIED_ROWS,
        rests=rests(
            "results/verification/verification.html",
            "results/verification/figures",
            files=content(*PAGE_FILES),
            code=code("verification"),
        ),
    output:
        page="results/verification/verification.html",
        figures=directory("results/verification/figures"),
    log:
        "results/verification/verification.log",
    shell:
        "python -m scripts.verification {output.page} {output.figures} {input.rows}"
        " --made {input.rests} --to {output} 2> {log}"


# after the page, so that the page shows a number outside its tolerance as well
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
