# Mesh the panel and find its modes and residual vectors.


rule panel:
    output:
        results("panel/modes.nc"),
        results("panel/modes.csv"),
        results("panel/modes.vtu"),
        results("panel/mesh.msh"),
        results("panel/section.csv"),
    log:
        results("panel/panel.log"),
    params:
        study=section("panel"),
        highest=STUDY.response.frequency_hz[1],
        files=content(*STUDY.panel.files),
        code=code("panel"),
    shell:
        'python -m scripts.panel "$PIDPANEL_STUDY" {output} 2> {log}'
