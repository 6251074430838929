"""Runs in the reduced basis against the whole model with the same inputs."""

import numpy as np
import pytest

from pidpanel import Model
from pidpanel.damping.broadband import CORRECTED_TONES
from pidpanel.margin.from_study import SpreadStudy
from pidpanel.margin.inputs.from_study import UncertainStudy
from pidpanel.study.uncertain import varied

SPREADS = {
    "panel.damping_ratio": {"lognormal": [0.008, 0.016], "source": "assumed"},
    "panel.section.bending_stiffness_n_m": {"normal": [3110, 3436], "source": "assumed"},
    "panel.supports.rotational_stiffness_n_rad": {"lognormal": [100, 3000], "source": "assumed"},
    "panel.patches.A.centre_m.0": {"uniform": [0.43, 0.47], "source": "assumed"},
    # its middle is not the 400 of the study
    "dampers.blanket.equivalent_damping_n_s_m3": {"normal": [390, 910], "source": "assumed"},
    "sound.air_density_kg_m3": {"uniform": [1.1, 1.3], "source": "assumed"},
    "sound.speed_m_s": {"uniform": [335, 350], "source": "assumed"},
}
STUDY = {
    "panel": {
        "outline_m": [1.0, 0.8],
        "section": {"mass_per_area_kg_m2": 4.0, "bending_stiffness_n_m": 3273.0},
        "supports": {"outline": "simply_supported", "rotational_stiffness_n_rad": 500},
        "damping_ratio": 0.012,
        "mesh": {"kind": "quadrilaterals", "elements": [10, 8]},
        "patches": {"A": {"centre_m": [0.45, 0.4], "size_m": [0.2, 0.2]}},
        "points": {"P": [0.5, 0.4], "Q": [0.2, 0.3]},
    },
    "dampers": {
        "blanket": {"equivalent_damping_n_s_m3": 400, "apparent_mass_kg_m2": 2.0},
        "heavy": {"equivalent_damping_n_s_m3": 5000, "apparent_mass_kg_m2": 6.0},
    },
    "sound": {
        "spectrum": "smc_s_016_2014_min_third.csv", "level": "median", "surroundings": "free",
    },
    "response": {"frequency_hz": [60, 500]},
    "scenarios": {
        "A": {"patch": "A", "damper": "blanket"}, "heavy": {"patch": "A", "damper": "heavy"},
    },
    "uncertain": SPREADS,
}  # fmt: skip


@pytest.fixture(scope="module")
def spread(tmp_path_factory):
    study = Model(STUDY, tmp_path_factory.mktemp("margin")).study
    samples = np.random.default_rng(2).standard_normal((4, len(SPREADS)))
    samples[3] = samples[2]
    samples[3, list(SPREADS).index("dampers.blanket.equivalent_damping_n_s_m3")] += 1.0
    return SpreadStudy(study, None, samples)


def whole(study, folder):
    """G rms of the bare panel, then with dampers, at the points."""
    model = Model(STUDY, folder)
    model.study = study
    return model.summary()["acceleration_rms_g"].to_numpy().reshape(3, -1)


@pytest.mark.slow
@pytest.mark.parametrize("number", [-1, 0, 1])
def test_a_run_is_within_half_a_percent_of_the_whole_model(spread, tmp_path, number):
    study = spread.uncertain.study
    if number >= 0:
        study = varied(study, spread.uncertain.values(spread.samples[number]))
    answer, _, _ = spread.run(number)
    assert answer.rms[:3] == pytest.approx(whole(study, tmp_path), rel=5e-3)


def test_the_panel_of_each_run_has_its_own_inputs(spread):
    basis = [spread.run(number)[1].basis for number in (0, 1)]
    values = [spread.uncertain.values(spread.samples[number]) for number in (0, 1)]
    for part, inputs in zip(basis, values, strict=True):
        assert part.damping_ratio[0] == pytest.approx(inputs["panel.damping_ratio"])
    assert abs(basis[0].natural_frequency[0] / basis[1].natural_frequency[0] - 1) > 1e-3


def test_bare_and_damped_share_their_inputs(spread):
    """A sound that is 12 dB lower moves a linear damper four times less."""
    answer, _, layouts = spread.run(0)
    assert layouts[2].factor == pytest.approx(10**-1.2)
    assert answer.rms[3] == pytest.approx(answer.rms[1] * 10**-0.6, rel=1e-9)


def test_runs_that_share_a_panel_are_those_of_each_alone(spread):
    together = [answer.rms for answer, _, _ in spread.runs([2, 3])]
    assert together[1] == pytest.approx(spread.run(3)[0].rms, rel=1e-12)
    assert (together[1][0] == together[0][0]).all()  # bare
    assert (together[1][1] < together[0][1]).all()


def test_the_error_of_single_tones_under_sound_is_in_the_spread(tmp_path):
    bed = {
        "cell": {"across_flats_mm": 6.35, "depth_mm": 25}, "particles": {"diameter_mm": 2.0},
        "model": "atlas",
    }  # fmt: skip
    study = Model(STUDY | {
        "dampers": {"blanket": STUDY["dampers"]["blanket"], "bed": bed},
        "scenarios": {"A": {"patch": "A", "damper": "blanket"},
                      "B": {"patch": "A", "damper": "bed", "fill_fraction": 0.5}},
    }, tmp_path).study  # fmt: skip
    uncertain = UncertainStudy(study, None)
    effect = np.array([[0.3, 0.1], [0.3, 0.1]])
    z = np.random.default_rng(0).standard_normal((4000, uncertain.size))
    error = np.std([uncertain.log_broadband(row, effect) for row in z], axis=0)
    assert (error[0] == 0).all()  # of a linear damper
    stated = np.hypot(CORRECTED_TONES.of_effect * effect[1], CORRECTED_TONES.of_rms)
    assert error[1] == pytest.approx(stated, rel=0.05)
