# Mesh the panel and find its modes and residual vectors.


rule panel:
    input:
        **RULES["panel"].input,
        request=request_of("panel"),
    output:
        **RULES["panel"].output,
    log:
        RULES["panel"].log,
    benchmark:
        results("benchmark/panel.tsv")
    params:
        job=job(**RULES["panel"].params),
    message:
        "Mesh and modes of the panel"
    shell:
        "python -m scripts.panel {params.job:q} 2> {log}"
