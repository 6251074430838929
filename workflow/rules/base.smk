# Random and sine motion of the supports: responses, effective masses, notches.


rule base:
    input:
        **RULES["base"].input,
        request=request_of("base"),
    output:
        **RULES["base"].output,
    log:
        RULES["base"].log,
    benchmark:
        results("benchmark/base.tsv")
    params:
        job=job(**RULES["base"].params),
    message:
        "Response to base motion"
    shell:
        "python -m scripts.base {params.job:q} 2> {log}"
