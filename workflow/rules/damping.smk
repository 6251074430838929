# From the cases of a coupon to C_e(r, f, Γ) and m_a(r, f, Γ), and to the constants of a law.

DAMPING_NAMES = ("surface.nc", "surface.csv", "law.csv", "forms.csv")


rule damping:
    input:
        results("coupon/cases.csv"),
    output:
        [results(f"damping/{name}") for name in DAMPING_NAMES],
    log:
        results("damping/damping.log"),
    params:
        study=lambda wildcards: coupon_digest(SECTION),
        code=code("damping"),
    shell:
        'python -m scripts.damping "$PIDPANEL_STUDY" coupon {input} {output} 2> {log}'


rule damper_damping:
    input:
        results("coupon/{damper}/cases.csv"),
    output:
        [results(f"damping/{{damper}}/{name}") for name in DAMPING_NAMES],
    log:
        results("damping/{damper}/damping.log"),
    params:
        study=lambda wildcards: coupon_digest(wildcards.damper),
        code=code("damping"),
    shell:
        'python -m scripts.damping "$PIDPANEL_STUDY" {wildcards.damper} {input} {output} 2> {log}'
