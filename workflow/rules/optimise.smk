# Layouts that are proposed within a mass budget.


rule optimise:
    input:
        **RULES["optimise"].input,
        request=request_of("optimise"),
    output:
        **RULES["optimise"].output,
    log:
        RULES["optimise"].log,
    benchmark:
        results("benchmark/optimise.tsv")
    threads: 2
    params:
        job=job(**RULES["optimise"].params),
    message:
        "Layouts within the mass budget"
    shell:
        "python -m scripts.optimise {params.job:q} 2> {log}"
