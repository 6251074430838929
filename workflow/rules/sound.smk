# The spectrum of the sound, the modal force of its field and, where it counts, the air's own.


rule sound:
    input:
        **RULES["sound"].input,
        request=request_of("sound"),
    output:
        **RULES["sound"].output,
    log:
        RULES["sound"].log,
    benchmark:
        results("benchmark/sound.tsv")
    params:
        job=job(**RULES["sound"].params),
    message:
        "Modal forces of the sound"
    shell:
        "python -m scripts.sound {params.job:q} 2> {log}"
