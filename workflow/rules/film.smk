# A shaken cell in motion, for the pages: some cycles after those that count.


rule film:
    input:
        cases=results("coupon/cases.csv"),
        request=request(results("coupon/film.nc"), study=lambda wildcards: PLAN.coupon()),
    output:
        film=results("coupon/film.nc"),
    log:
        results("coupon/film.log"),
    benchmark:
        results("benchmark/film.tsv")
    params:
        job=job(damper=SECTION),
    message:
        "Film a run of the coupon"
    shell:
        "python -m scripts.film {params.job:q} 2> {log}"


rule damper_film:
    input:
        cases=results("coupon/{damper}/cases.csv"),
        request=request(
            results("coupon/{damper}/film.nc"),
            study=lambda wildcards: PLAN.coupon(wildcards.damper),
        ),
    output:
        film=results("coupon/{damper}/film.nc"),
    log:
        results("coupon/{damper}/film.log"),
    benchmark:
        results("benchmark/film_{damper}.tsv")
    params:
        job=job(damper=lambda wildcards: wildcards.damper),
    message:
        "Film a run of damper {wildcards.damper}"
    shell:
        "python -m scripts.film {params.job:q} 2> {log}"
