# A shaken cell in motion, for the pages: some cycles after those that count.


rule film:
    input:
        cases=rules.cases.output.cases,
    output:
        film=results(f"coupon/{DAMPER}film.nc"),
    log:
        results(f"coupon/{DAMPER}film.log"),
    benchmark:
        results(f"benchmark/{DAMPER}film.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        damper=damper_of,
        coupon=coupon,
    message:
        "Film a run of {params.damper}"
    script:
        "../scripts/film.py"
