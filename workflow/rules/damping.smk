# From the cases to C_e(r, f, Γ) and m_a(r, f, Γ), and to the constants of a law.


rule damping:
    input:
        results("coupon/cases.csv"),
    output:
        results("damping/surface.nc"),
        results("damping/surface.csv"),
        results("damping/law.csv"),
        results("damping/forms.csv"),
    log:
        results("damping/damping.log"),
    params:
        study=section("coupon"),
        code=code("damping"),
    shell:
        'python -m scripts.damping "$PIDPANEL_STUDY" {input} {output} 2> {log}'
