# From the cases of a coupon to C_e(r, f, Γ) and m_a(r, f, Γ), and to the constants of a law.

DAMPING_NAMES = {
    "surface": "surface.nc",
    "table": "surface.csv",
    "law": "law.csv",
}
DAMPING = {key: results(f"damping/{name}") for key, name in DAMPING_NAMES.items()}
DAMPER_DAMPING = {key: results(f"damping/{{damper}}/{name}") for key, name in DAMPING_NAMES.items()}


rule damping:
    input:
        cases=results("coupon/cases.csv"),
        request=request(*DAMPING.values(), study=lambda wildcards: PLAN.coupon()),
    output:
        **DAMPING,
    log:
        results("damping/damping.log"),
    benchmark:
        results("benchmark/damping.tsv")
    params:
        job=job(damper=SECTION),
    message:
        "Damping of the coupon"
    shell:
        "python -m scripts.damping {params.job:q} 2> {log}"


rule damper_damping:
    input:
        cases=results("coupon/{damper}/cases.csv"),
        request=request(
            *DAMPER_DAMPING.values(),
            study=lambda wildcards: PLAN.coupon(wildcards.damper),
        ),
    output:
        **DAMPER_DAMPING,
    log:
        results("damping/{damper}/damping.log"),
    benchmark:
        results("benchmark/damping_{damper}.tsv")
    params:
        job=job(damper=lambda wildcards: wildcards.damper),
    message:
        "Damping of damper {wildcards.damper}"
    shell:
        "python -m scripts.damping {params.job:q} 2> {log}"
