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
        file=STUDY_FILE,
        study=section("coupon"),
        code=code("damping"),
    shell:
        "python -m scripts.damping {params.file} {input} {output} 2> {log}"


# With a target, rounds choose the cases: round 0 spreads them over the sweep, each further one
# looks at what the panel makes of the cases before it.


wildcard_constraints:
    round=r"\d+",


checkpoint design:
    input:
        before=round_before,
        modes=results("panel/modes.nc"),
        modal_force=results("sound/modal_force.nc"),
        air=AIR,
    output:
        results("design/round{round}.json"),
    log:
        results("design/round{round}.log"),
    params:
        file=STUDY_FILE,
        before=lambda wildcards: round_before(wildcards) or "none none",
        air=AIR or "none",
        study=section("coupon", "damping", "panel", "sound", "response", "scenarios"),
        code=code("damping", "response"),
    shell:
        "python -m scripts.design {params.file} {input.modes} {input.modal_force} {params.air}"
        " {params.before} {output} 2> {log}"


rule round_cases:
    input:
        outcomes_of_round,
    output:
        results("design/cases{round}.csv"),
    log:
        results("design/cases{round}.log"),
    params:
        file=STUDY_FILE,
        chosen=lambda wildcards: results(f"design/round{wildcards.round}.json"),
        code=code("coupon"),
    shell:
        "python -m scripts.cases {params.file} results/coupon {params.chosen} {output} 2> {log}"


rule tabdmp1:
    input:
        modes=results("panel/modes.nc"),
        psd=results("response/psd.nc"),
    output:
        results("damping/tabdmp1.bdf"),
    log:
        results("damping/tabdmp1.log"),
    params:
        file=STUDY_FILE,
        code=code("response/tabdmp1.py"),
    shell:
        "python -m scripts.tabdmp1 {params.file} {input.modes} {input.psd} {output} 2> {log}"
