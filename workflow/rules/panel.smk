# Mesh the panel and find its modes and residual vectors.

from pidpanel.panel.from_study import damper_masses

PANEL_NAMES = ("modes.nc", "modes.csv", "modes.vtu", "mesh.msh", "section.csv", "plate.nc")
PANEL = [results(f"panel/{name}") for name in PANEL_NAMES]


rule panel:
    input:
        rests=rests(
            *PANEL,
            study=section("panel"),
            # the basis follows the panel with its heaviest dampers
            damper_mass=text_digest([json.dumps(damper_masses(STUDY), sort_keys=True)]),
            highest=STUDY.response.frequency_hz[1],
            speed=STUDY.sound.speed_m_s,
            files=content(*STUDY.panel.files),
            code=code("panel"),
        ),
    output:
        PANEL,
    log:
        results("panel/panel.log"),
    shell:
        'python -m scripts.panel "$PIDPANEL_STUDY" {output}'
        " --made {input.rests} --to {output} 2> {log}"
