# From the cases of a coupon to C_e(r, f, Γ) and m_a(r, f, Γ), and to the constants of a law.

DAMPING_NAMES = ("surface.nc", "surface.csv", "law.csv", "forms.csv")
DAMPING = [results(f"damping/{name}") for name in DAMPING_NAMES]
DAMPER_DAMPING = [results(f"damping/{{damper}}/{name}") for name in DAMPING_NAMES]


rule damping:
    input:
        cases=results("coupon/cases.csv"),
        rests=rests(
            *DAMPING,
            study=lambda wildcards: coupon_digest(SECTION),
            code=code("damping"),
        ),
    output:
        DAMPING,
    log:
        results("damping/damping.log"),
    shell:
        'python -m scripts.damping "$PIDPANEL_STUDY" coupon {input.cases} {output}'
        " --made {input.rests} --to {output} 2> {log}"


rule damper_damping:
    input:
        cases=results("coupon/{damper}/cases.csv"),
        rests=rests(
            *DAMPER_DAMPING,
            study=lambda wildcards: coupon_digest(wildcards.damper),
            code=code("damping"),
        ),
    output:
        DAMPER_DAMPING,
    log:
        results("damping/{damper}/damping.log"),
    shell:
        'python -m scripts.damping "$PIDPANEL_STUDY" {wildcards.damper} {input.cases} {output}'
        " --made {input.rests} --to {output} 2> {log}"
