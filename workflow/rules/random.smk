# Coupons driven at random with the motion of their own patches: rounds of the coupon and the panel
# until both agree. This loop from the response back to the coupon is here and nowhere else.

# what changes no motion of a patch
NOT_FOR_RANDOM = {
    "response": {"maps", "radiation_beside"},
    "damping": {"target", "tones", "coupled"},
}


wildcard_constraints:
    round=r"\d+",
    leg=r"\d+",
    drive=r"\d+",
    seed=r"\d+",


checkpoint random_round:
    input:
        before=random_before,
        modes=results("panel/modes.nc"),
        modal_force=results("sound/modal_force.nc"),
        air=AIR,
        rests=rests(
            results("random/round{round}.json"),
            results("random/impedance{round}.csv"),
            study=section("coupon", *RESPONSE_SECTIONS, without=NOT_FOR_RANDOM),
            dampers=DAMPERS,
            scenarios=SCENARIOS,
            code=code("random_round"),
        ),
    output:
        results("random/round{round}.json"),
        results("random/impedance{round}.csv"),
    log:
        results("random/round{round}.log"),
    params:
        folder=lambda wildcards, output: str(Path(output[0]).parent),
        air=AIR or "none",
    shell:
        'python -m scripts.random_round "$PIDPANEL_STUDY" {input.modes} {input.modal_force}'
        " {params.air} {params.folder} {wildcards.round} {output}"
        " --made {input.rests} --to {output} 2> {log}"


rule random_leg:
    input:
        round=results("random/round{leg}.json"),
        start=leg_before,
        rests=rests(
            results("random/leg{leg}/{drive}_s{seed}.npz"),
            coupon=lambda wildcards: damper_digest(RANDOM_DAMPERS[wildcards.drive]),
            deck=commands("random.in.j2", "header.j2", "contacts.j2"),
            # not of the study's models: legs are expensive
            code=lambda wildcards: digest_of_code("pidpanel.coupon.random_runs"),
        ),
    output:
        results("random/leg{leg}/{drive}_s{seed}.npz"),
    log:
        results("random/leg{leg}/{drive}_s{seed}.log"),
    params:
        bed=bed_of_leg,
        before=lambda wildcards, input: "none" if wildcards.leg == "0" else input.start,
        folder=lambda wildcards, output: str(Path(output[0]).with_suffix("")),
    shell:
        'python -m scripts.random_leg "$PIDPANEL_STUDY" {input.round} {wildcards.drive}'
        " {wildcards.seed} {params.bed} {params.before} {params.folder} {output}"
        " --made {input.rests} --to {output} 2> {log}"
