# From the cases of a coupon to C_e(r, f, Γ) and m_a(r, f, Γ), and to the constants of a law.


rule damping:
    input:
        cases=rules.cases.output.cases,
    output:
        surface=results("damping/surface.nc"),
        table=results("damping/surface.csv"),
        law=results("damping/law.csv"),
    log:
        results("damping/damping.log"),
    benchmark:
        results("benchmark/damping.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        damper=SECTION,
        coupon=lambda wildcards: coupon(),
    message:
        "Damping of the coupon"
    script:
        "../scripts/damping.py"


use rule damping as damper_damping with:
    input:
        cases=rules.damper_cases.output.cases,
    output:
        surface=results("damping/{damper}/surface.nc"),
        table=results("damping/{damper}/surface.csv"),
        law=results("damping/{damper}/law.csv"),
    log:
        results("damping/{damper}/damping.log"),
    benchmark:
        results("benchmark/damping_{damper}.tsv")
    params:
        version=VERSION,
        damper=lambda wildcards: wildcards.damper,
        coupon=lambda wildcards: coupon(wildcards.damper),
    message:
        "Damping of damper {wildcards.damper}"


# what stages read that need the damping of the scenarios
SURFACES = [damper_file("damping", damper, "surface.nc") for damper in STUDY.surfaces]
COUPLED = list(rules.coupled.output) if STUDY.is_coupled else []
