"""Small studies and files that are right, to be made wrong by one change of their text."""

from pathlib import Path
from typing import NamedTuple

import pytest

from pidpanel.check import checked_study
from pidpanel.study import StudyError

SPECTRUM = """\
# a launch spectrum
center_hz,spl_db
63,124
80,126
100,128
125,130
160,131
200,131.5
250,131
315,130
400,128.5
500,127
"""

TABLE = """\
# shaker test
fill_fraction,frequency_hz,acceleration_g,equivalent_damping_n_s_m3,apparent_mass_kg_m2
0.4,100,1,820,5.1
0.4,400,1,1450,4.6
0.4,100,10,510,2.2
0.4,400,10,1100,1.9
0.8,100,1,1820,9.1
0.8,400,1,2450,8.6
0.8,100,10,1510,4.2
0.8,400,10,2100,3.9
"""

IMPEDANCE = """\
frequency_hz,equivalent_damping_n_s_m3,apparent_mass_kg_m2
100,820,5.1
400,1450,4.6
"""

COUPON = """\
coupon:
  cell:
    shape: hexagon
    across_flats_mm: 6.35
    depth_mm: 10
    count: 2
  particles:
    diameter_mm: 2.5
    density_kg_m3: 1190
    youngs_modulus_mpa: 50
    poissons_ratio: 0.35
    restitution: 0.8
    friction: 0.3
    rolling_friction: 0.0
  gravity_g: 1
  gravity_direction: [0, 0, -1]
  time_step_rayleigh: 0.2
  samples_per_cycle: 100
  sweep:
    fill_fraction: [0.4, 0.8]
    frequency_hz: [100, 400]
    acceleration_g: [10, 100]
    max_velocity_m_s: 7
  accuracy:
    relative_error: 0.25
    seeds: 2
    min_cycles: 10
    min_time_s: 0.05
    max_cycles: 60
    coverage: 0.8
"""

SOUND = """\
sound:
  spectrum: spectrum.csv
  oaspl_db: 150
  field: diffuse
  speed_m_s: 343
  air_density_kg_m3: 1.2
"""

THIN = (
    """\
title: A small panel
assumptions:
  - "The paper's law."
damping:
  readings: [paper_corrected]
panel:
  outline_m: [1.5, 1.0]
  section:
    kind: thin
    mass_per_area_kg_m2: 4.0
    bending_stiffness_n_m: 3273.07
    thickness_mm: 25
    poissons_ratio: 0.3
  supports: simply_supported
  damping_ratio: 0.02
  mesh:
    kind: quadrilaterals
    elements: [15, 10]
  patches:
    PID-1:
      centre_m: [0.75, 0.5]
      size_m: [0.3, 0.2]
    Left wing:
      centre_m: [0.3, 0.5]
      size_m: [0.2, 0.2]
  points:
    centre: [0.7, 0.5]
    Edge: [0.1, 0.5]
"""
    + SOUND
    + """\
response:
  frequency_hz: [100, 400]
  damper_mass: true
scenarios:
  fill:
    title: Effect of fill
    patch: PID-1
    fill_fraction: [0.4, 0.8]
  place:
    patch: [PID-1, Left wing]
    fill_fraction: 0.5
"""
)

FULL = COUPON + THIN.replace("[paper_corrected]", "[dem]").replace("0.5\n", "0.6\n")

SANDWICH = (
    """\
panel:
  outline_m: [[0, 0], [1.5, 0], [1.5, 1.0], [0, 1.0]]
  corner_radius_m: 0.08
  holes:
    cut-out:
      centre_m: [1.05, 0.65]
      diameter_m: 0.24
  section:
    kind: sandwich
    materials:
      tape:
        e1_gpa: 280
        e2_gpa: 6.5
        g12_gpa: 4.5
        nu12: 0.3
        density_kg_m3: 1600
      foil:
        youngs_modulus_gpa: 70
        poissons_ratio: 0.33
        density_kg_m3: 2700
    faces:
      - material: tape
        thickness_mm: 0.1
        angle_deg: 60
      - material: foil
        thickness_mm: 0.2
    core:
      shear_modulus_l_mpa: 186
      shear_modulus_w_mpa: 90
      density_kg_m3: 32
      thickness_mm: 24.4
      ribbon_deg: 0
    extra_mass_per_area_kg_m2: 1.0
  supports:
    outline: free
    holes: free
    edges:
      - from_m: [0.2, 0]
        to_m: [0.6, 0]
        kind: clamped
    points:
      Hinge:
        at_m: [0.3, 0.86]
        kind: hinge
        radius_m: 0.02
      mount:
        at_m: [1.2, 0.9]
        kind: spring
        stiffness_n_m: 1.0e+5
  masses:
    Box:
      at_m: [0.75, 0.1]
      mass_kg: 0.2
    harness:
      from_m: [0.1, 0.5]
      to_m: [0.8, 0.5]
      mass_kg: 0.5
  damping_ratio: 0.01
  mesh:
    kind: triangles
    size_m: 0.08
  patches:
    round:
      centre_m: [0.4, 0.3]
      diameter_m: 0.2
    slanted:
      corners_m: [[0.1, 0.6], [0.3, 0.6], [0.3, 0.8], [0.1, 0.7]]
  points:
    P1: [0.4, 0.3]
    P2: [0.2, 0.65]
"""
    + SOUND
    + """\
response:
  frequency_hz: [100, 400]
dampers:
  lab:
    table: lab.csv
  Tuned:
    impedance: tuned.csv
  foil:
    equivalent_damping_n_s_m3: 2000
    apparent_mass_kg_m2: 3
  layer:
    loss_factor: 0.1
    patch_mass_per_area_kg_m2: 5
scenarios:
  fill:
    patch: round
    damper: lab
    fill_fraction: [0.4, 0.8]
  both:
    layout:
      round: {damper: Tuned}
      slanted: {damper: foil}
"""
)

DECK = """\
$ a panel of 1.2 m x 0.8 m in mm; property 2 is the patch
BEGIN BULK
GRID,1,,0.0,0.0,0.0
GRID,2,,400.0,0.0,0.0
GRID,3,,800.0,0.0,0.0
GRID,4,,1200.0,0.0,0.0
GRID,5,,0.0,400.0,0.0
GRID,6,,400.0,400.0,0.0
GRID,7,,800.0,400.0,0.0
GRID,8,,1200.0,400.0,0.0
GRID,9,,0.0,800.0,0.0
GRID,10,,400.0,800.0,0.0
GRID,11,,800.0,800.0,0.0
GRID,12,,1200.0,800.0,0.0
CQUAD4,1,1,1,2,6,5
CQUAD4,2,2,2,3,7,6
CQUAD4,3,1,3,4,8,7
CQUAD4,4,1,5,6,10,9
CQUAD4,5,1,6,7,11,10
CTRIA3,6,1,7,8,12
CTRIA3,7,1,7,12,11
ENDDATA
"""

GMSH = """\
$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
2 1 "plain"
2 2 "middle"
$EndPhysicalNames
$Nodes
6
1 0 0 0
2 400 0 0
3 800 0 0
4 0 400 0
5 400 400 0
6 800 400 0
$EndNodes
$Elements
2
1 3 2 1 1 1 2 5 4
2 3 2 2 2 2 3 6 5
$EndElements
"""

FROM_FILE = (
    """\
panel:
  mesh:
    kind: file
    file: panel.bdf
    unit_m: 0.001
  section:
    kind: solid
    youngs_modulus_gpa: 70
    poissons_ratio: 0.33
    density_kg_m3: 2700
    thickness_mm: 100
  supports:
    outline: free
    points:
      H1:
        grid: 1
        kind: hinge
  masses:
    box:
      grid: 6
      mass_kg: 0.3
  damping_ratio: 0.01
  patches:
    middle:
      group: 2
  points:
    centre:
      grid: 7
    corner: [1.2, 0.8]
"""
    + SOUND
    + """\
damping:
  readings: [paper_corrected]
response:
  frequency_hz: [100, 400]
scenarios:
  fill:
    patch: middle
    fill_fraction: [0.4, 0.8]
"""
)

BASES = {
    "thin": THIN,
    "coupon": COUPON,
    "full": FULL,
    "sandwich": SANDWICH,
    "file": FROM_FILE,
}
FILES = {
    "spectrum.csv": SPECTRUM,
    "lab.csv": TABLE,
    "tuned.csv": IMPEDANCE,
    "panel.bdf": DECK,
    "panel.msh": GMSH,
}


class Place(NamedTuple):
    """A study in a folder of its own, with the files that it names."""

    folder: Path
    study: Path

    def told(self) -> list[str]:
        """The lines of the refusal, none if the study is accepted; without the folder."""
        try:
            checked_study(self.study)
        except StudyError as error:
            return str(error).replace(f"{self.folder}/", "").split("\n")
        return []


def replaced(text: str, old: str, new: str) -> str:
    """The text with its only (or first) ``old`` changed; at the end where there is no ``old``."""
    if not old:
        return text + new
    assert old in text, f"not in the base: {old}"
    return text.replace(old, new, 1)


@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    """Where the files of all studies are; a test leaves it as it was."""
    made = tmp_path_factory.mktemp("corpus")
    for name, text in FILES.items():
        (made / name).write_text(text, encoding="utf-8")
    return made


@pytest.fixture
def written(folder):
    """(text or bytes of the study) → its place."""

    def write(study, name="mine.yaml"):
        path = folder / name
        path.write_bytes(study if isinstance(study, bytes) else study.encode())
        return Place(folder, path)

    return write


@pytest.fixture(scope="session")
def bases():
    return BASES


@pytest.fixture(scope="session")
def files():
    return FILES


@pytest.fixture(scope="session")
def change():
    return replaced


@pytest.fixture
def wrong(written):
    """Assert that a base with one change is refused with these lines.

    A line begins with ``@text|`` where it is told elsewhere than where the change begins: at the
    line of that text, or of the file as a whole for no text.
    """

    def check(base, old, new, *says):
        study = replaced(BASES[base], old, new)
        expected = []
        for one in says:
            at = new.split("\n")[0] if old else new.strip().split("\n")[0]
            start = study.index(at) if at in study else 0
            line = study[: start if old else study.rindex(at)].count("\n") + 1
            if old:
                line = BASES[base][: BASES[base].index(old)].count("\n") + 1
            if one.startswith("@"):
                at, one = one[1:].split("|", 1)
                line = study[: study.index(at)].count("\n") + 1 if at else 0
                one = one.strip()
            expected.append(f"mine.yaml:{line}: {one}" if line else f"mine.yaml: {one}")
        assert written(study).told() == expected

    return check
