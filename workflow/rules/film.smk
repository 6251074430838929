# A shaken cell in motion, for the pages: some cycles after those that count.

FILMS = [coupon_file("coupon", damper, "film.nc") for damper in STUDY.coupons]


rule film:
    input:
        cases=results("coupon/cases.csv"),
        rests=rests(
            results("coupon/film.nc"),
            study=lambda wildcards: coupon_digest(SECTION),
            code=code("film"),
        ),
    output:
        results("coupon/film.nc"),
    log:
        results("coupon/film.log"),
    shell:
        'python -m scripts.film "$PIDPANEL_STUDY" coupon {input.cases} results/coupon {output}'
        " --made {input.rests} --to {output} 2> {log}"


rule damper_film:
    input:
        cases=results("coupon/{damper}/cases.csv"),
        rests=rests(
            results("coupon/{damper}/film.nc"),
            study=lambda wildcards: coupon_digest(wildcards.damper),
            code=code("film"),
        ),
    output:
        results("coupon/{damper}/film.nc"),
    log:
        results("coupon/{damper}/film.log"),
    shell:
        'python -m scripts.film "$PIDPANEL_STUDY" {wildcards.damper} {input.cases} results/coupon'
        " {output} --made {input.rests} --to {output} 2> {log}"
