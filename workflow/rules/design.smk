# With a target, rounds choose the cases: round 0 spreads them over the sweep, each further one
# computes what the panel makes of the cases before it. With tones, round 0 is the whole sweep, and
# further cases follow at the motions of the scenarios. The loop from the response back to the
# coupon is here and nowhere else.


wildcard_constraints:
    round=r"\d+",


checkpoint design:
    input:
        before=round_before,
        modes=results("panel/modes.nc"),
        modal_force=results("sound/modal_force.nc"),
        air=AIR,
        rests=rests(
            results("design/round{round}.json"),
            study=section("coupon", *RESPONSE_SECTIONS, without={"response": {"maps"}}),
            scenarios=SCENARIOS,
            code=code("design"),
        ),
    output:
        results("design/round{round}.json"),
    log:
        results("design/round{round}.log"),
    params:
        before=lambda wildcards: round_before(wildcards) or "none none",
        air=AIR or "none",
    shell:
        'python -m scripts.design "$PIDPANEL_STUDY" {input.modes} {input.modal_force} {params.air}'
        " {params.before} {output} --made {input.rests} --to {output} 2> {log}"


rule round_cases:
    input:
        outcomes=outcomes_of_round,
        rests=rests(results("design/cases{round}.csv"), code=code("cases")),
    output:
        results("design/cases{round}.csv"),
    log:
        results("design/cases{round}.log"),
    params:
        chosen=lambda wildcards: results(f"design/round{wildcards.round}.json"),
    shell:
        'python -m scripts.cases "$PIDPANEL_STUDY" coupon results/coupon {params.chosen} {output}'
        " --made {input.rests} --to {output} 2> {log}"
