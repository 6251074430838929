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
    # Snakemake gives BLAS the threads of a rule, which changes bits; the search has its own
    shell:
        "OMP_NUM_THREADS=1 python -m scripts.optimise {params.job:q} 2> {log}"
