"""Spreads of inputs, and those that are refused."""

import copy

import numpy as np
import pytest

from pidpanel import Model, StudyError
from pidpanel.study.uncertain import REACH, Spread, number_at, varied, way_of

SPREAD = {"normal": [0.008, 0.012], "source": "assumed"}
STUDY = {
    "panel": {
        "outline_m": [1.0, 0.8],
        "section": {"mass_per_area_kg_m2": 4.0, "bending_stiffness_n_m": 3273.0},
        "damping_ratio": 0.01,
        "mesh": {"kind": "quadrilaterals", "elements": [10, 8]},
        "patches": {
            "A.1": {"centre_m": [0.45, 0.4], "size_m": [0.2, 0.2]},
            "C": {"centre_m": [0.75, 0.4], "size_m": [0.2, 0.2]},
        },
        "points": {"P": [0.5, 0.4]},
    },
    "dampers": {
        "blanket": {"equivalent_damping_n_s_m3": 400},
        "bed": {
            "cell": {"across_flats_mm": 6.35, "depth_mm": 25},
            "particles": {"diameter_mm": 2.0},
            "model": "atlas",
        },
    },
    "sound": {"spectrum": "smc_s_016_2014_min_third.csv", "level": "median"},
    "response": {"frequency_hz": [60, 300]},
    "scenarios": {
        "A": {"patch": "A.1", "damper": "blanket"},
        "B": {"patch": "A.1", "damper": "bed", "fill_fraction": 0.5},
        "C": {"layout": {name: {"damper": "bed", "fill_fraction": 0.5} for name in ("A.1", "C")}},
    },
    "uncertain": {"panel.damping_ratio": SPREAD},
}


def study_with(**uncertain):
    values = copy.deepcopy(STUDY)
    values["uncertain"] |= uncertain
    return values


@pytest.mark.parametrize(
    ("key", "spread", "parts"),
    [
        ("panel.damping_ratio", {"normal": [0.001, 0.02], "source": "a"}, ["reaches", "3 σ"]),
        ("panel.damping_ratio", {"normal": [0.01, 0.02]}, ["source", "missing"]),
        ("panel.damping_ratio", {"normal": [0.01, 0.02], "source": " "}, ["source"]),
        ("panel.damping_ratio", {"normal": [0.02, 0.01], "source": "a"}, ["second above"]),
        ("panel.damping_ratio", {"lognormal": [0, 0.01], "source": "a"}, ["above 0"]),
        ("panel.section.kind", SPREAD, ["number"]),
        ("panel.section.none", SPREAD, ["no such key", "none"]),
        ("panel.mesh.elements", SPREAD, ["must be panel.damping_ratio"]),
        ("panel.patches.A.1.centre_m.0", {"normal": [0.1, 0.6], "source": "a"}, ["on the panel"]),
        ("sound.spectrum", {"normal": [-3, 3], "source": "a"}, ["correlation_octaves"]),
        ("sound.speed_m_s", {"normal": [330, 350], "source": "a", "correlation_octaves": 1},
         ["correlation_octaves"]),
        ("panel.damping_ratio", {"normal": [float("nan"), 0.02], "source": "a"}, ["finite"]),
        ("panel.damping_ratio", {"normal": [0.01, 0.02, 0.03], "source": "a"}, ["2 values"]),
        ("panel.damping_ratio", {"source": "a"}, ["normal", "lognormal", "uniform"]),
        ("panel.damping_ratio", 0.01, ["mapping"]),
        ("panel.damping_ratio", {"normal": [0.05, 0.08], "source": "a"},
         ["contain", "0.01", "0.03764"]),
        ("panel.damping_ratio.", SPREAD, ["must be panel.damping_ratio"]),
        ("panel.patches.A.1.centre_m.2", SPREAD, ["centre_m.0"]),
        ("panel.patches.B.centre_m.0", SPREAD, ["no such key", "B"]),
        ("dampers..friction", SPREAD, ["no such key"]),
        ("dampers.bed.model", SPREAD, ["number", "str"]),
        ("dampers.bed.particles.friction", {"normal": [0.1, 0.9], "source": "a"}, ["-0.2295"]),
        ("panel.patches.A.1.centre_m.0", {"uniform": [0.4, 0.6], "source": "a"},
         ["reaches 0.5997", "covers cells of A.1"]),
        ("dampers.bed.particles.diameter_mm", {"normal": [0.3, 3.7], "source": "a"},
         ["reaches"]),
        ("scenarios.B.fill_fraction", {"normal": [0.4, 1.2], "source": "a"}, ["1.53", "to 1"]),
        ("sound.speed_m_s", {"normal": [10, 600], "source": "a"}, ["reaches -233", "100 to 1400"]),
        ("sound.spectrum", {"normal": [1, 3], "source": "a", "correlation_octaves": 1},
         ["-x and x", "sound.shift_db"]),
        ("sound.spectrum", {"normal": [-30, 30], "source": "a", "correlation_octaves": 1},
         ["at most 20 dB"]),
    ],
)  # fmt: skip
def test_a_spread_that_cannot_be_is_refused_at_its_key_in_one_line(tmp_path, key, spread, parts):
    with pytest.raises(StudyError) as refused:
        Model(study_with(**{key: spread}), tmp_path)
    message = str(refused.value)
    assert message.startswith(f"uncertain.{key}")
    assert len(message.splitlines()) == 1
    for part in parts:
        assert part in message


@pytest.mark.parametrize(("level", "is_refused"), [("p95_50", True), (None, True), ("test", False)])
def test_scatter_of_a_level_needs_a_level_that_does_not_contain_it(tmp_path, level, is_refused):
    values = study_with(**{"sound.shift_db": {"normal": [-2, 2], "source": "assumed"}})
    values["sound"]["level"] = level
    if is_refused:
        with pytest.raises(StudyError, match=r"uncertain\.sound\.shift_db"):
            Model(values, tmp_path)
    else:
        assert Model(values, tmp_path).study.acoustics.level == level


def test_correlations_that_contradict_each_other_are_refused(tmp_path):
    keys = ["panel.damping_ratio", "sound.speed_m_s", "sound.air_density_kg_m3"]
    values = study_with(**{
        keys[1]: {"normal": [335, 350], "source": "a"},
        keys[2]: {"normal": [1.1, 1.3], "source": "a"},
    })  # fmt: skip
    pairs = [(0, 1, 0.9), (1, 2, 0.9), (0, 2, -0.9)]
    values["margin"] = {
        "correlations": [{"keys": [keys[i], keys[j]], "coefficient": r} for i, j, r in pairs]
    }
    with pytest.raises(StudyError, match=r"margin\.correlations.*positive definite.*-0\.8"):
        Model(values, tmp_path)


def test_a_pair_of_inputs_has_one_correlation(tmp_path):
    keys = ["panel.damping_ratio", "sound.speed_m_s"]
    values = study_with(**{keys[1]: {"normal": [335, 350], "source": "a"}})
    pairs = [(keys, 0.5), (keys[::-1], -0.5)]
    values["margin"] = {"correlations": [{"keys": k, "coefficient": r} for k, r in pairs]}
    with pytest.raises(StudyError, match=r"margin\.correlations\[1\].*each pair once"):
        Model(values, tmp_path)


@pytest.mark.parametrize(
    ("way", "ends"),
    [
        (("dampers", "bed", "particles", "friction"), "0.2507, 0.3493"),
        (("dampers", "bed", "particles", "restitution"), "0.2507, 0.3493"),
        (("scenarios", "B", "fill_fraction"), "0.2507, 0.3493"),
    ],
)
def test_an_error_of_a_number_counts_once(tmp_path, way, ends):
    """It would not count in the margin; the message has the spread that does."""
    values = study_with()
    section = values
    for key in way[:-1]:
        section = section.setdefault(key, {})
    section[way[-1]] = {"value": 0.3, "error": 0.03}
    with pytest.raises(StudyError, match=rf"^{'.'.join(way)}.*normal: \[{ends}\]"):
        Model(values, tmp_path)


@pytest.mark.parametrize("kind", ["normal", "lognormal", "uniform"])
def test_the_two_values_of_a_spread_are_what_they_are_said_to_be(kind):
    spread = Spread.model_validate({kind: (0.5, 2.0), "source": "a"})
    values = [spread.value(z) for z in np.random.default_rng(0).standard_normal(200_000).tolist()]
    ends = (0, 1) if kind == "uniform" else (0.05, 0.95)
    assert np.quantile(values, ends) == pytest.approx([0.5, 2.0], abs=0.02)
    assert max(values) <= spread.value(REACH)


def test_a_key_is_changed_alone_also_behind_a_name_with_a_dot(tmp_path):
    study = Model(STUDY, tmp_path).study
    key = "panel.patches.A.1.centre_m.0"
    changed = varied(study, {key: 0.47})
    assert number_at(changed, way_of(changed, key)) == 0.47
    assert changed.panel.patches["A.1"].centre_m == (0.47, 0.4)
    assert study.panel.patches["A.1"].centre_m == (0.45, 0.4)
    assert changed.panel.section == study.panel.section
