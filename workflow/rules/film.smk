# A shaken cell in motion, for the pages: some cycles after those that count.


rule film:
    input:
        cases=rules.cases.output.cases,
    output:
        film=results("coupon/film.nc"),
    log:
        results("coupon/film.log"),
    benchmark:
        results("benchmark/film.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        damper=SECTION,
        coupon=lambda wildcards: coupon(),
    message:
        "Film a run of the coupon"
    script:
        "../scripts/film.py"


use rule film as damper_film with:
    input:
        cases=rules.damper_cases.output.cases,
    output:
        film=results("coupon/{damper}/film.nc"),
    log:
        results("coupon/{damper}/film.log"),
    benchmark:
        results("benchmark/film_{damper}.tsv")
    params:
        version=VERSION,
        damper=lambda wildcards: wildcards.damper,
        coupon=lambda wildcards: coupon(wildcards.damper),
    message:
        "Film a run of damper {wildcards.damper}"
