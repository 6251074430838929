# PSDs of every scenario with every damping model; maps; files for other programs.


rule response:
    input:
        **RULES["response"].input,
        request=request_of("response"),
    output:
        **RULES["response"].output,
    log:
        RULES["response"].log,
    benchmark:
        results("benchmark/response.tsv")
    params:
        job=job(**RULES["response"].params),
    message:
        "Response of the panel in all scenarios"
    shell:
        "python -m scripts.response {params.job:q} 2> {log}"


rule maps:
    input:
        **RULES["maps"].input,
        request=request_of("maps"),
    output:
        maps=RULES["maps"].output["maps"],
        folder=directory(RULES["maps"].output["folder"]),
    log:
        RULES["maps"].log,
    benchmark:
        results("benchmark/maps.tsv")
    params:
        job=job(**RULES["maps"].params),
    message:
        "Maps of rms acceleration"
    shell:
        "python -m scripts.maps {params.job:q} 2> {log}"


rule export:
    input:
        **RULES["export"].input,
        request=request_of("export"),
    output:
        folder=directory(RULES["export"].output["folder"]),
    log:
        RULES["export"].log,
    benchmark:
        results("benchmark/export.tsv")
    params:
        job=job(**RULES["export"].params),
    message:
        "Files for other programs"
    shell:
        "python -m scripts.export {params.job:q} 2> {log}"
