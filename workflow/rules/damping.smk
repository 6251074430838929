# From the cases of a coupon to C_e(r, f, Γ) and m_a(r, f, Γ), and to the constants of a law.


rule damping:
    input:
        cases=rules.cases.output.cases,
    output:
        surface=results("damping/{damper}/surface.nc"),
        table=results("damping/{damper}/surface.csv"),
        law=results("damping/{damper}/law.csv"),
    log:
        results("damping/{damper}/damping.log"),
    benchmark:
        results("benchmark/damping_{damper}.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        damper=damper_of,
        coupon=coupon,
    message:
        "Damping of damper {wildcards.damper}"
    script:
        "../scripts/damping.py"


# what stages read that need the damping of the scenarios
SURFACES = [damper_file("damping", damper, "surface.nc") for damper in STUDY.coupons]
COUPLED = list(rules.coupled.output) if STUDY.is_coupled else []
