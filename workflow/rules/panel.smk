# Mesh the panel and find its modes and residual vectors.


rule panel:
    output:
        results("panel/modes.nc"),
        results("panel/modes.csv"),
        results("panel/modes.vtu"),
        results("panel/mesh.msh"),
    params:
        folder=results("panel"),
        study=section("panel", "response"),
        code=code("panel"),
    log:
        results("panel/panel.log"),
    shell:
        "{PYTHON} {SCRIPTS}/panel.py {STUDY_FILE} {params.folder} 2> {log}"
