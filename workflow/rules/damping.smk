# From the cases to C_e(r, f, Γ) and m_a(r, f, Γ).


rule damping:
    input:
        results("coupon/cases.csv"),
    output:
        results("damping/surface.nc"),
    params:
        code=code("damping"),
    log:
        results("damping/damping.log"),
    shell:
        "{PYTHON} {SCRIPTS}/damping.py {STUDY_FILE} {input} {output} 2> {log}"
