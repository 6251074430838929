# From the cases to C_e(r, f, Γ) and m_a(r, f, Γ).


rule damping:
    input:
        results("coupon/cases.csv"),
    output:
        results("damping/surface.nc"),
    params:
        file=STUDY_FILE,
        code=code("damping"),
    log:
        results("damping/damping.log"),
    shell:
        "python -m scripts.damping {params.file} {input} {output} 2> {log}"
