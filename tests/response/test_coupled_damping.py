"""Coupled runs as a damping model: C_e, m_a and own force of their table, errors of the others."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping.coupled import CoupledDamping, read_coupled
from pidpanel.response.model_error import read_errors

NODES = np.array([100.0, 400.0])
BED = CoupledDamping(
    frequency=NODES,
    equivalent_damping=np.array([400.0, 900.0]),
    equivalent_damping_error=np.array([40.0, 180.0]),
    apparent_mass=np.array([2.0, 1.0]),
    apparent_mass_error=np.array([0.2, 0.3]),
    own_psd=np.array([1.0, 16.0]),
    own_coherence=np.array([0.8, 0.2]),
    own_length=30.0,
    cell_area=4e-5,
    weight=6.0,
)


def asked(bed, *frequency):
    return bed(np.array(frequency), 0.5, 10.0)


def test_between_nodes_the_damping_is_a_power_and_the_mass_linear_in_the_logarithm():
    # half way in ln f; held beyond
    found = asked(BED, 50.0, 200.0, 1600.0)
    assert found.equivalent_damping == pytest.approx([400.0, 600.0, 900.0])
    assert found.apparent_mass == pytest.approx([2.0, 1.5, 1.0])
    assert found.inside.all()
    # relative errors of 10 and 20 %, independent
    relative = found.equivalent_damping_error / found.equivalent_damping
    assert relative == pytest.approx([0.1, np.hypot(0.05, 0.1), 0.2])


def test_the_covariance_is_that_of_the_nodes_and_of_all_together():
    bed = CoupledDamping(**{**vars(BED), "common_error": 0.3})
    damping = np.diag([0.1**2, 0.2**2]) + 0.3**2
    mass = np.diag([0.2**2, 0.3**2]) + 0.3**2 * np.array([[4.0, 2.0], [2.0, 1.0]])
    # the nodes and half way between
    hats = np.array([[1.0, 0.0], [0.5, 0.5], [0.0, 1.0]])
    found = bed.covariance(np.array([100.0, 200.0, 400.0]), 0.5, 10.0)
    assert found[:3, :3] == pytest.approx(hats @ damping @ hats.T)
    assert found[3:, 3:] == pytest.approx(hats @ mass @ hats.T)
    assert not found[:3, 3:].any()
    # what it states of single lines is its diagonal
    stated = asked(bed, 100.0, 200.0, 400.0)
    relative = stated.equivalent_damping_error / stated.equivalent_damping
    assert relative**2 == pytest.approx(np.diag(found)[:3])


def test_parts_of_a_patch_have_one_damper():
    f = np.array([150.0, 300.0])
    found = BED.cross_covariance(f, (0.5, 10.0), (0.5, 3.0))
    assert found == pytest.approx(BED.covariance(f, 0.5, 10.0))
    assert not BED.depends_on_acceleration


def test_without_mass_the_damping_stays():
    bed, f = BED.without_mass(), np.array([150.0, 300.0])
    assert asked(bed, *f).apparent_mass.tolist() == [0.0, 0.0]
    assert asked(bed, *f).equivalent_damping == pytest.approx(asked(BED, *f).equivalent_damping)
    covariance = bed.covariance(f, 0.5, 10.0)
    assert not covariance[2:, 2:].any()
    assert covariance[:2, :2] == pytest.approx(BED.covariance(f, 0.5, 10.0)[:2, :2])
    # the particles still weigh
    assert bed.mass_per_area(0.5) == 6.0


def test_what_is_not_resolved_does_not_feed_the_panel():
    # C_e of −50 ± 100 counts as 50 with an error of its double
    unresolved = {"equivalent_damping": [-50.0, 900.0], "equivalent_damping_error": [100.0, 180.0]}
    bed = CoupledDamping(**{**vars(BED), **{k: np.array(v) for k, v in unresolved.items()}})
    found = asked(bed, 100.0)
    assert found.equivalent_damping == pytest.approx([50.0])
    assert found.equivalent_damping_error == pytest.approx([100.0])


def test_the_own_force_is_a_power_and_its_coherence_linear():
    psd, coherence = BED.own_force(np.array([50.0, 200.0, 800.0]))
    assert psd == pytest.approx([1.0, 4.0, 16.0])
    assert coherence == pytest.approx([0.8, 0.5, 0.2])
    none = CoupledDamping(**{**vars(BED), "own_psd": np.zeros(2)})
    assert none.own_force(NODES)[0].max() < 1e-200


def rows(scenario, patch, damping, common):
    return pd.DataFrame(
        {
            "scenario": scenario, "patch": patch, "band_hz": NODES, "frequency_hz": NODES * 1.01,
            "equivalent_damping_n_s_m3": damping, "equivalent_damping_error_n_s_m3": 50.0,
            "apparent_mass_kg_m2": 2.0, "apparent_mass_error_kg_m2": 0.2,
            "own_force_psd_pa2_hz": [3.0, 5.0], "own_force_coherence": [0.9, 0.1],
            "own_force_error": 0.1, "own_force_length_m_hz": 42.0, "cell_area_m2": 4e-5,
            "particle_mass_per_area_kg_m2": 6.0, "common_error": common,
        }
    )  # fmt: skip


def test_a_table_of_coupled_runs_is_read_by_scenario_and_patch(tmp_path):
    # names that are numbers stay names
    path = tmp_path / "impedance.csv"
    parts = [
        rows("140", "01", 9.0, 0.3)[:1],  # of a single band
        rows("130", "01", 500.0, 0.0),
        rows("130", "02", 700.0, 0.0),
    ]
    pd.concat(parts).to_csv(path, index=False)
    found = read_coupled(path)
    assert list(found) == [("140", "01"), ("130", "01"), ("130", "02")]
    bed = found["130", "02"]
    assert bed.nodes.tolist() == pytest.approx([101.0, 404.0])
    assert asked(bed, 200.0).equivalent_damping == pytest.approx([700.0])
    assert asked(bed, 200.0).apparent_mass == pytest.approx([2.0])
    assert (bed.own_length, bed.cell_area, bed.mass_per_area(0.3)) == (42.0, 4e-5, 6.0)
    assert [values.tolist() for values in bed.own_force(bed.nodes)] == [
        pytest.approx([3.0, 5.0]),
        pytest.approx([0.9, 0.1]),
    ]
    assert (bed.common_error, found["140", "01"].common_error) == (0.0, 0.3)


def test_errors_are_those_of_the_runs(tmp_path):
    frequency = np.array([30.0, 100.0, 1000.0])
    errors = {("two", "326"): 2.0, ("two", "7"): 3.0, ("one", "326"): 0.5, ("one", "7"): 1.0}
    pd.DataFrame(
        [
            {"scenario": scenario, "point": point, "g_rms": 10.0, "g_rms_error": error / 2}
            for (scenario, point), error in errors.items()
        ]
    ).to_csv(tmp_path / "summary.csv", index=False)
    pd.concat(
        pd.DataFrame(
            {
                "scenario": scenario,
                "point": point,
                "frequency_hz": frequency,
                "error_db": error * np.array([1.0, 1.0, 2.0]),
            }
        )
        for (scenario, point), error in errors.items()
    ).to_csv(tmp_path / "psd.csv", index=False)
    found = read_errors(tmp_path, np.array([50.0, 10**2.5]), ["7", "326"])
    assert list(found) == ["two", "one"]
    assert found["one"].log_rms == pytest.approx([0.05, 0.025])
    assert found["two"].log_rms == pytest.approx([0.15, 0.1])
    # linear in ln f: half way from 100 to 1000 Hz
    wanted = np.log(10) / 10 * np.array([[3.0, 2.0], [4.5, 3.0]])
    assert found["two"].log_psd == pytest.approx(wanted)
