"""Steady acceleration of the launch: which beds feel it, and what cannot."""

import math

import numpy as np
import pytest

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled.from_study import coupled_scenarios
from pidpanel.damping.from_study import dampers_of
from pidpanel.study import StudyError, load_study
from pidpanel.study.coupon import Coupon

STUDY = """
panel:
  outline_m: [1.5, 1.0]
  section: {kind: thin, mass_per_area_kg_m2: 4.0, bending_stiffness_n_m: 3273, thickness_mm: 25}
  supports: simply_supported
  damping_ratio: 0.01
  mesh: {kind: quadrilaterals, elements: [30, 20]}
  patches: {A: {centre_m: [0.75, 0.5], size_m: [0.2, 0.2]}}
  points: {p: [0.75, 0.5]}
dampers:
  acrylic: {particles: {diameter_mm: 2, density_kg_m3: 1190}, model: MODEL}
sound: {spectrum: smc_s_016_2014_min_third.csv}
response: {frequency_hz: [30, 400]}
scenarios:
  pad: {patch: A, fill_fraction: 0.5}
  lift-off: {patch: A, fill_fraction: 0.5, steady_acceleration_g: VECTOR}
"""


@pytest.fixture
def load(tmp_path):
    """A study with a damping model and the steady acceleration of a scenario."""

    def study(model, vector, **replaced):
        text = STUDY.replace("MODEL", model).replace("VECTOR", str(vector))
        for old, new in replaced.items():
            text = text.replace(old, new)
        file = tmp_path / "study.yaml"
        file.write_text(text)
        return load_study(file)

    return study


@pytest.mark.parametrize(
    ("gravity", "direction", "steady", "total"),
    [(1, (0, 0, -2), (0, 0, -3), 4), (1, (0, 0, -1), (0, 0, 1), 0), (1, (3, 4, 0), (0, 0, 1), 2**0.5)],
)  # fmt: skip
def test_steady_acceleration_and_gravity_add_as_vectors(gravity, direction, steady, total):
    coupon = Coupon(gravity_g=gravity, gravity_direction=direction, steady_acceleration_g=steady)
    assert coupon.gravity == pytest.approx(total * STANDARD_GRAVITY, abs=1e-12)
    assert math.hypot(*coupon.gravity_axis) == pytest.approx(1)


def test_a_scenario_gives_its_particles_in_liggghts_its_own_steady_acceleration(load):
    study = load("coupled", [0, 0, -3])
    beds = {name: s.patches[0].beds[0] for name, s in coupled_scenarios(study).items()}
    assert {name: bed.gravity / STANDARD_GRAVITY for name, bed in beds.items()} == {
        "A_r0.5": 1,
        "A_r0.5_z-3g": pytest.approx(4),
    }


def test_a_steady_acceleration_of_the_sound_is_that_of_every_bed_that_states_none(load):
    sound = {"third.csv}": "third.csv, steady_acceleration_g: [0, 0, -1]}"}
    study = load("coupled", [0, 0, -3], **sound)
    beds = [s.patches[0].beds[0] for s in coupled_scenarios(study).values()]
    assert [bed.gravity / STANDARD_GRAVITY for bed in beds] == pytest.approx([2, 4])


def test_the_atlas_scales_with_the_acceleration_that_the_bed_feels(load):
    """With G times the gravity equal groups are at G times Γ and √G times f: η = C_e/(m″ω) stays."""
    models = dampers_of(load("atlas", [0, 0, -3]), is_broadband=False)
    frequency = np.array([60.0, 150.0, 400.0])
    for gamma in (6.0, 20.0, 60.0):
        light = models["acrylic"](frequency, 0.5, gamma)
        heavy = models["acrylic_z-3g"](2 * frequency, 0.5, 4 * gamma)
        assert heavy.equivalent_damping / 2 == pytest.approx(light.equivalent_damping, rel=1e-9)
        assert heavy.apparent_mass == pytest.approx(light.apparent_mass, rel=1e-9)


@pytest.mark.parametrize(
    ("model", "vector", "place"),
    [
        ("tones, sweep: {fill_fraction: [0.5], frequency_hz: [100], acceleration_g: [10]}",
         [0, 0, -3], "lift-off.steady_acceleration_g"),
        ("atlas", [0, 0, 1], "lift-off.steady_acceleration_g"),
        ("coupled", [0, 0, -30], "lift-off.steady_acceleration_g"),
        ("coupled", -3, "lift-off.steady_acceleration_g"),
    ],
)  # fmt: skip
def test_what_a_scenario_cannot_feel_is_refused_there(load, model, vector, place):
    with pytest.raises(StudyError, match=place) as error:
        load(model, vector)
    assert len(str(error.value).splitlines()) == 1


def test_stated_damping_feels_no_steady_acceleration(load):
    table = {"particles: {diameter_mm: 2, density_kg_m3: 1190}, model: coupled": "loss_factor: 0.1, patch_mass_per_area_kg_m2: 2",
             "fill_fraction: 0.5, ": "", "fill_fraction: 0.5": "title: x"}  # fmt: skip
    with pytest.raises(StudyError, match="none of its dampers"):
        load("coupled", [0, 0, -3], **table)
