# From the cases to C_e(r, f, Γ) and m_a(r, f, Γ).


rule damping:
    input:
        results("coupon/cases.csv"),
    output:
        results("damping/surface.nc"),
        results("damping/surface.csv"),
    log:
        results("damping/damping.log"),
    params:
        file=STUDY_FILE,
        code=code("damping"),
    shell:
        "python -m scripts.damping {params.file} {input} {output} 2> {log}"
