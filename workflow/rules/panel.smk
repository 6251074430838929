# Mesh the panel and find its modes and residual vectors.

PANEL = {
    "modes": results("panel/modes.nc"),
    "table": results("panel/modes.csv"),
    "shapes": results("panel/modes.vtu"),
    "mesh": results("panel/mesh.msh"),
    "section": results("panel/section.csv"),
    "plate": results("panel/plate.nc"),
}


rule panel:
    input:
        request=request(
            *PANEL.values(),
            study=section("panel"),
            # basis and mesh follow the panel with its heaviest dampers
            damper_mass=values_digest(damper_masses(STUDY)),
            resolved_mass=values_digest(resolved_masses(STUDY)),
            highest=STUDY.response.frequency_hz[1],
            speed=STUDY.sound.speed_m_s,
        ),
    output:
        **PANEL,
    log:
        results("panel/panel.log"),
    benchmark:
        results("benchmark/panel.tsv")
    params:
        job=job(),
    message:
        "Mesh and modes of the panel"
    shell:
        "python -m scripts.panel {params.job:q} 2> {log}"
