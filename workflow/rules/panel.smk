# Mesh the panel and find its modes and residual vectors.


rule panel:
    output:
        modes=results("panel/modes.nc"),
        table=results("panel/modes.csv"),
        shapes=results("panel/modes.vtu"),
        mesh=results("panel/mesh.msh"),
        section=results("panel/section.csv"),
        plate=results("panel/plate.nc"),
    log:
        results("panel/panel.log"),
    benchmark:
        results("benchmark/panel.tsv")
    resources:
        mem_mb=1000,
    params:
        version=VERSION,
        panel=section("panel"),
        # basis and mesh follow the panel with its heaviest dampers
        damper_mass=STUDY.damper_masses(),
        resolved_mass=STUDY.damper_masses(with_rows=True),
        highest=STUDY.response.frequency_hz[1],
        speed=STUDY.wave_speed,
    message:
        "Mesh and modes of the panel"
    script:
        "../scripts/panel.py"


REPORTED += [rules.panel.output[key] for key in ("modes", "table", "section")]
