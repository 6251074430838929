# Rounds of tones: round 0 is the whole sweep, further cases follow at the motions of the scenarios.
# The loop from the response back to the coupon is here and nowhere else.


def last_round():
    """The round that wants no more cases."""
    number = 0
    while True:
        file = checkpoints.design.get(round=number).output[0]
        if Round.read(Path(file)).is_last:
            return file
        number += 1


def before(name):
    """A file of the round before; none before the first."""

    def file_of(wildcards):
        number = int(wildcards.round) - 1
        return results(f"design/{name.format(number)}") if number >= 0 else []

    return file_of


def this_round(wildcards):
    """The round of a table of cases."""
    return checkpoints.design.get(round=wildcards.round).output[0]


checkpoint design:
    input:
        before=before("round{}.json"),
        cases=before("cases{}.csv"),
        modes=PANEL["modes"],
        modal_force=SOUND["modal_force"],
        air=AIR,
        request=request(
            results("design/round{round}.json"),
            study=section("coupon", *RESPONSE_SECTIONS, without={"response": {"maps"}}),
            scenarios=SCENARIOS,
        ),
    output:
        round=results("design/round{round}.json"),
    log:
        results("design/round{round}.log"),
    benchmark:
        results("benchmark/design_{round}.tsv")
    params:
        job=job(),
    message:
        "Round {wildcards.round} of tones"
    shell:
        "python -m scripts.design {params.job:q} 2> {log}"


rule round_cases:
    input:
        outcomes=lambda wildcards: RUNS.outcomes(RUNS.cases_of_round(this_round(wildcards))),
        round=this_round,
        request=request(results("design/cases{round}.csv")),
    output:
        cases=results("design/cases{round}.csv"),
    log:
        results("design/cases{round}.log"),
    benchmark:
        results("benchmark/round_cases_{round}.tsv")
    params:
        job=job(damper=SECTION),
    message:
        "Gather the cases of round {wildcards.round}"
    shell:
        "python -m scripts.cases {params.job:q} 2> {log}"
