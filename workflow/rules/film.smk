# A shaken cell in motion, for the pages: some cycles after those that count.

FILMS = [coupon_file("coupon", damper, "film.nc") for damper in STUDY.coupons]


rule film:
    input:
        results("coupon/cases.csv"),
    output:
        results("coupon/film.nc"),
    log:
        results("coupon/film.log"),
    params:
        study=lambda wildcards: coupon_digest(SECTION),
        code=code("film"),
    shell:
        'python -m scripts.film "$PIDPANEL_STUDY" coupon {input} results/coupon {output} 2> {log}'


rule damper_film:
    input:
        results("coupon/{damper}/cases.csv"),
    output:
        results("coupon/{damper}/film.nc"),
    log:
        results("coupon/{damper}/film.log"),
    params:
        study=lambda wildcards: coupon_digest(wildcards.damper),
        code=code("film"),
    shell:
        'python -m scripts.film "$PIDPANEL_STUDY" {wildcards.damper} {input} results/coupon'
        " {output} 2> {log}"
