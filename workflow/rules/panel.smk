# Mesh the panel and find its modes and residual vectors.


rule panel:
    output:
        results("panel/modes.nc"),
        results("panel/modes.csv"),
        results("panel/modes.vtu"),
        results("panel/mesh.msh"),
    log:
        results("panel/panel.log"),
    params:
        file=STUDY_FILE,
        study=section("panel", "response"),
        code=code("panel"),
    shell:
        "python -m scripts.panel {params.file} {output} 2> {log}"
