"""What the studies that come with pidpanel say, in SI, and which scenarios they ask for."""

import ast
import math
from pathlib import Path

import pytest
import yaml

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.study import load_any_study, load_study
from pidpanel.study.coupon import Coupon
from pidpanel.study.coupon_study import VariedCoupon
from pidpanel.study.panel import Panel
from pidpanel.study.section import MaterialInput

STUDIES = Path(__file__).parents[2] / "workflow" / "studies"
PACKAGE = STUDIES.parents[1] / "src" / "pidpanel"
SWEEP = {"frequency_hz": [100], "acceleration_g": [10]}


@pytest.mark.parametrize("name", sorted(p.name for p in STUDIES.glob("*.yaml")))
def test_every_shipped_study_is_accepted(name):
    assert load_any_study(STUDIES / name).name == name.removesuffix(".yaml")


def test_the_units_of_the_coupon_become_si():
    coupon = load_study(STUDIES / "paper.yaml").dampers["acrylic"]
    assert coupon.cell.depth == 0.025
    assert coupon.cell.across_flats == 0.00635
    assert coupon.particles.youngs_modulus == 3.2e9
    assert coupon.stiffness.choices == (50e6, 200e6, 800e6)
    assert coupon.stiffness.from_acceleration_g == 10
    assert coupon.gravity == STANDARD_GRAVITY
    assert coupon.diameters == (0.002,)
    assert coupon.sweep.accelerations == tuple(g * STANDARD_GRAVITY for g in (20, 120, 700))
    assert coupon.sweep.displacements == ()
    sweep = {"frequency_hz": [100], "displacement_mm": [0.5], "diameter_mm": [1, 2]}
    swept = Coupon.model_validate({"sweep": sweep})
    assert swept.sweep.displacements == (0.5e-3,)
    assert swept.diameters == (0.001, 0.002)
    assert swept.walls.youngs_modulus is None
    assert swept.walls.model_copy(update={"youngs_modulus_mpa": 200}).youngs_modulus == 200e6


def test_the_units_of_the_panel_become_si():
    assert load_study(STUDIES / "paper.yaml").panel.section.thickness == 0.025
    section = load_study(STUDIES / "sandwich_hole_hinge.yaml").panel.section
    assert section.thickness == pytest.approx(0.0244 + 6 * 0.0001)
    assert section.core.thickness == pytest.approx(0.0244, rel=1e-15)  # a rounding of 24.4e-3
    assert section.core.properties == (186e6, 90e6, 32.0)
    assert section.core.ribbon == 0
    assert section.core.model_copy(update={"ribbon_deg": 90}).ribbon == math.pi / 2
    assert [ply.thickness for ply in section.faces] == [0.1 * 1e-3] * 3
    assert [ply.angle for ply in section.faces] == [0, math.radians(60), -math.radians(60)]
    tape = section.materials["tape"]
    assert (tape.e1, tape.e2, tape.g12) == (280e9, 6.5e9, 4.5e9)
    assert section.materials["tape"].youngs_modulus is None
    isotropic = MaterialInput(youngs_modulus_gpa=60, poissons_ratio=0.3, density_kg_m3=1600)
    assert isotropic.youngs_modulus == 60e9


def test_the_units_of_a_study_become_si_nowhere_else():
    for stage in ("coupon", "damping", "panel", "sound", "response"):
        for path in (PACKAGE / stage).rglob("*.py"):
            for node in ast.walk(ast.parse(path.read_text())):
                name = getattr(node, "attr", "")
                assert not name.endswith(("_mm", "_mpa", "_gpa", "_deg")), f"{path}: {name}"


def test_angles_of_waves_become_radians():
    sound = load_study(STUDIES / "smoke.yaml").sound
    assert sound.incidence == math.pi / 2
    assert sound.azimuth == 0
    turned = sound.model_copy(update={"incidence_deg": 30, "azimuth_deg": 180})
    assert turned.incidence == pytest.approx(math.pi / 6)
    assert turned.azimuth == math.pi


@pytest.mark.parametrize(
    ("distribution", "sizes"),
    [
        ({"kind": "mono"}, ("mono", 0.002, 0.002, 0.0)),
        ({"kind": "normal", "deviation_mm": 0.25}, ("normal", 0.0015, 0.0025, 0.0)),
        ({"kind": "uniform", "half_width_mm": 0.5}, ("uniform", 0.0015, 0.0025, 0.0)),
        ({"kind": "binary", "second_mm": 3, "second_share": 0.2}, ("binary", 0.002, 0.003, 0.2)),
        ({"kind": "binary", "second_mm": 1, "second_share": 0.2}, ("binary", 0.001, 0.002, 0.8)),
    ],
)
def test_distributions_have_their_sizes_in_m(distribution, sizes):
    coupon = Coupon.model_validate({"sweep": SWEEP, "particles": {"distribution": distribution}})
    found = coupon.particles.distribution.sizes(2.0 * 1e-3)
    assert (found.kind, found.large_share) == (sizes[0], sizes[3])
    assert (found.smallest, found.largest) == pytest.approx(sizes[1:3])


def test_a_hollow_particle_has_the_density_of_its_mass_over_its_outer_volume():
    shell = {"diameter_mm": 2, "shell_mm": 0.3, "density_kg_m3": 1000}
    particles = Coupon.model_validate({"sweep": SWEEP, "particles": shell}).particles
    assert particles.effective_density(2.0 * 1e-3) == pytest.approx(1000 * (2**3 - 1.4**3) / 2**3)


def test_a_variant_is_the_coupon_with_the_values_of_vary():
    vary = {"particles.friction": [0.1, 0.6], "gravity_direction": [[0, 0, -1], [1, 0, 0]]}
    coupon = VariedCoupon.model_validate({"sweep": SWEEP, "vary": vary})
    variants = coupon.variants()
    assert [(variant.particles.friction, variant.gravity_direction) for _, variant in variants] == [
        (0.1, (0, 0, -1)),
        (0.1, (1, 0, 0)),
        (0.6, (0, 0, -1)),
        (0.6, (1, 0, 0)),
    ]
    assert variants[1][0] == {"particles.friction": 0.1, "gravity_direction": [1, 0, 0]}
    assert all(variant.sweep == coupon.sweep for _, variant in variants)


def test_a_coupon_that_varies_nothing_is_its_own_variant():
    coupon = Coupon.model_validate({"sweep": SWEEP})
    assert coupon.variants() == (({}, coupon),)


def test_a_rectangle_has_its_bounds_and_a_panel_its_outline_in_m():
    panel = load_study(STUDIES / "paper.yaml").panel
    assert panel.patches["PID-1"].bounds == (0.65, 0.85, 0.4, 0.6)
    assert panel.size == (1.5, 1.0)
    assert panel.outline.corners.tolist() == [[0, 0], [1.5, 0], [1.5, 1], [0, 1]]
    assert panel.support_input.outline == "simply_supported"


def test_a_group_of_a_mesh_file_is_text_whether_a_number_or_not():
    values = yaml.safe_load((STUDIES / "bdf_panel.yaml").read_text())["panel"]
    assert values["patches"]["middle"] == {"group": 2}
    assert Panel.model_validate(values).patches["middle"].group == "2"


def test_the_first_bare_panel_is_mapped_unless_others_are_named():
    assert [s.label for s in load_study(STUDIES / "smoke.yaml").mapped_scenarios()] == [
        "bare_150dB"
    ]
    named = load_study(STUDIES / "paper.yaml").mapped_scenarios()
    assert [s.label for s in named] == [
        "bare_162dB", "PID-1_acrylic_r0.5_162dB", "PID-1_atlas_r0.5_162dB", "PID-1_paper_r0.5_162dB",
    ]  # fmt: skip


def test_every_level_brings_its_bare_panel_first():
    scenarios = load_study(STUDIES / "paper.yaml").all_scenarios()
    bare = [s.label for s in scenarios if s.patch is None]
    assert bare == ["bare_162dB", "bare_142dB", "bare_152dB"]
    assert [s.patch for s in scenarios[:3]] == [None] * 3
    assert len({s.label for s in scenarios}) == len(scenarios)


def test_a_family_takes_the_level_of_the_sound_unless_it_has_its_own():
    study = load_study(STUDIES / "paper.yaml")
    assert {s.oaspl_db for s in study.family_scenarios("fill")} == {162}
    assert [s.oaspl_db for s in study.family_scenarios("level")] == 3 * [142, 152, 162]
    assert study.scenarios["level"].varied == "oaspl_db"
    assert study.scenarios["location"].varied == "patch"


def test_a_scenario_at_the_level_of_its_table_has_no_level_in_its_name():
    scenario = load_study(STUDIES / "l_panel.yaml").family_scenarios("location")[1]
    assert scenario.label == "corner_r0.5"
    assert scenario.bare.label == "bare"


def test_a_single_scenario_needs_no_list(tmp_path):
    text = (STUDIES / "l_panel.yaml").read_text()
    start = text.index("scenarios:")
    single = "scenarios:\n  one: {patch: arm, fill_fraction: 0.5, oaspl_db: 140}\n"
    (tmp_path / "one.yaml").write_text(text[:start] + single)
    labels = [scenario.label for scenario in load_study(tmp_path / "one.yaml").all_scenarios()]
    assert labels == ["bare_140dB", "arm_r0.5_140dB"]
