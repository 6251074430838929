# Mesh the panel and find its modes and residual vectors.


rule panel:
    input:
        mesh=STUDY.panel.mesh.file or [],
    output:
        results("panel/modes.nc"),
        results("panel/modes.csv"),
        results("panel/modes.vtu"),
        results("panel/mesh.msh"),
        results("panel/section.csv"),
    log:
        results("panel/panel.log"),
    params:
        file=STUDY_FILE,
        study=section("panel", "response"),
        code=code("panel", "polygon.py"),
    shell:
        "python -m scripts.panel {params.file} {output} 2> {log}"
