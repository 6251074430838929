# Mesh the panel and find its modes and residual vectors.


rule panel:
    output:
        results("panel/modes.nc"),
        results("panel/modes.csv"),
        results("panel/modes.vtu"),
        results("panel/mesh.msh"),
        results("panel/section.csv"),
        results("panel/plate.nc"),
    log:
        results("panel/panel.log"),
    params:
        study=section("panel"),
        # the basis follows the panel with its heaviest dampers
        damper_mass=text_digest([json.dumps(damper_masses(STUDY), sort_keys=True)]),
        highest=STUDY.response.frequency_hz[1],
        speed=STUDY.sound.speed_m_s,
        files=content(*STUDY.panel.files),
        code=code("panel"),
    shell:
        'python -m scripts.panel "$PIDPANEL_STUDY" {output} 2> {log}'
