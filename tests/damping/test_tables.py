"""A table says what it says: at its rows, between them, beyond them, with its errors or none."""

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as st

from pidpanel.damping.broadband import EXACT, SINGLE_TONES
from pidpanel.damping.from_study import read_table
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_files import to_frame
from pidpanel.damping.table_files import COLUMNS, read_columns
from pidpanel.damping.tables import TableDamping

F, C, M = "frequency_hz", "equivalent_damping_n_s_m3", "apparent_mass_kg_m2"
C_ERROR, M_ERROR = "equivalent_damping_error_n_s_m3", "apparent_mass_error_kg_m2"
PARTICLES = "particle_mass_per_area_kg_m2"
G = 9.80665


def reading(interpolation="log", **columns):
    count = max(np.size(values) for values in columns.values())
    full = {name: np.full(count, values, float) for name, values in columns.items()}
    assert set(full) <= set(COLUMNS)
    return TableDamping(full, interpolation)


def at(table, frequency, fill=0.5, gamma=10.0):
    return table(np.atleast_1d(np.asarray(frequency, float)), fill, gamma)


# ------------------------------------------------------------------------ as it stands


@pytest.mark.parametrize("interpolation", ["log", "linear"])
def test_two_rows_are_a_constant_at_every_fill_and_motion(interpolation):
    # before, a Gaussian process over the onset of a poured bed: 6 to 25 % off between the rows,
    # nothing at or below 1 g, and a hundred rows for a constant
    table = reading(interpolation, **{F: [10, 2000], C: 2000.0, M: 3.0})
    frequency = np.geomspace(10, 2000, 333)
    for gamma in (0.01, 0.99, 1.0, 1.01, 300.0, np.nan):
        for fill in (0.02, 0.5, 1.0):
            found = table(frequency, fill, gamma)
            assert (found.equivalent_damping == 2000.0).all()
            assert (found.apparent_mass == 3.0).all()
            assert (found.equivalent_damping_error == 0).all()
            assert found.inside.all()
    assert not table.depends_on_acceleration
    assert table.nodes is None


@pytest.mark.parametrize(("axis", "error"), [({}, EXACT), ({"acceleration_g": 10}, SINGLE_TONES)])
def test_a_table_with_an_amplitude_is_of_single_tones(axis, error):
    assert reading(**{F: [10, 2000], C: 2000.0}, **axis).broadband_error is error


def test_dead_weight_is_a_table_too():
    # C_e = 0 was refused
    table = reading(**{F: [20, 500], C: 0.0, M: 4.0})
    found = at(table, [20, 77, 500])
    assert (found.equivalent_damping == 0).all() and (found.apparent_mass == 4).all()


ROWS = st.lists(
    st.tuples(st.sampled_from([0.1, 0.5, 0.9]), st.sampled_from([20.0, 80.0, 300.0, 1000.0]),
              st.sampled_from([0.2, 1.0, 30.0])),
    min_size=1, unique=True,
)  # fmt: skip
AMPLITUDE = {
    "acceleration_g": lambda f, gamma: gamma,
    "displacement_mm": lambda f, gamma: 1e3 * gamma * G / (2 * np.pi * f) ** 2,
    "velocity_m_s": lambda f, gamma: gamma * G / (2 * np.pi * f),
}


@pytest.mark.slow
@given(ROWS, st.sampled_from(list(AMPLITUDE)), st.sampled_from(["log", "linear"]),
       st.sampled_from([C, "loss_factor", "impedance"]), st.data())  # fmt: skip
def test_any_table_reads_back_at_its_rows(rows, amplitude, interpolation, kind, data):
    # whatever amplitude and value it is written in
    fill, frequency, gamma = np.array(rows).T
    omega = 2 * np.pi * frequency
    number = st.floats(1e-3, 1e4)
    damping = np.array([data.draw(st.one_of(st.just(0.0), number)) for _ in rows])
    mass = np.array([data.draw(st.floats(-50, 50)) for _ in rows])
    columns = {
        "fill_fraction": fill,
        F: frequency,
        amplitude: AMPLITUDE[amplitude](frequency, gamma),
    }
    if kind == "impedance":
        columns |= {"impedance_real_n_s_m3": damping, "impedance_imag_n_s_m3": omega * mass}
    elif kind == "loss_factor":
        columns |= {"loss_factor": damping / (12 * fill * omega), PARTICLES: 12 * fill, M: mass}
    else:
        columns |= {C: damping, M: mass}
    table = TableDamping(columns, interpolation)
    for r, f, level, value, own in zip(fill, frequency, gamma, damping, mass, strict=True):
        found = at(table, f, r, level)
        # Γ becomes a displacement and back: a few roundings of 1e-16, times the steepest slope,
        # ln 1e7 over a step of ln 3.75, of the logarithm of a value
        assert found.equivalent_damping[0] == pytest.approx(value, rel=1e-12, abs=1e-9)
        assert found.apparent_mass[0] == pytest.approx(own, rel=1e-12, abs=1e-12)
        assert found.inside.all()


def test_what_is_interpolated_is_what_is_given():
    # a constant displacement amplitude, loss factor or reactance is constant between its rows
    f = np.array([100.0, 170.0, 400.0])
    omega = 2 * np.pi * f
    for interpolation in ("log", "linear"):
        eta = reading(interpolation, **{F: [100, 400], "loss_factor": 0.2, PARTICLES: 3.0})
        np.testing.assert_allclose(at(eta, f).equivalent_damping, 0.2 * 3.0 * omega, rtol=1e-14)
        spring = reading(
            interpolation,
            **{F: [100, 400], "impedance_real_n_s_m3": 7.0, "impedance_imag_n_s_m3": -50.0},
        )
        found = at(spring, f)
        assert (found.equivalent_damping == 7.0).all()
        np.testing.assert_allclose(found.apparent_mass, -50.0 / omega, rtol=1e-14)
    stroke = reading(**{F: [50, 500, 50, 500], "displacement_mm": [0.1, 0.1, 1, 1],
                        C: [30, 30, 3, 3]})  # fmt: skip
    gamma = 1e-4 * (2 * np.pi * 200.0) ** 2 / G
    assert at(stroke, 200.0, gamma=gamma).equivalent_damping[0] == pytest.approx(30.0, rel=1e-12)


def test_logarithmic_and_linear_are_what_is_asked_for():
    columns = {F: [100, 400], C: [10.0, 40.0], M: [1.0, 4.0]}
    log, linear = reading("log", **columns), reading("linear", **columns)
    assert at(log, 200.0).equivalent_damping[0] == pytest.approx(20.0)
    assert at(log, 200.0).apparent_mass[0] == pytest.approx(2.0)
    assert at(linear, 200.0).equivalent_damping[0] == pytest.approx(20.0)
    assert at(linear, 250.0).equivalent_damping[0] == pytest.approx(25.0)
    assert at(log, 250.0).equivalent_damping[0] == pytest.approx(25.0)
    bent = {F: [100, 400], C: [10.0, 10.0 * 4**2]}
    assert at(reading("log", **bent), 200.0).equivalent_damping[0] == pytest.approx(40.0)
    assert at(reading("linear", **bent), 200.0).equivalent_damping[0] == pytest.approx(60.0)


# ------------------------------------------------------------------------ what it weighs


def test_particles_weigh_what_the_table_says():
    # linear in the fill, held beyond
    table = reading(**{"fill_fraction": [0.2, 0.2, 0.6], F: [100, 200, 100], C: 5.0,
                       PARTICLES: [2.0, 2.0, 6.0]})  # fmt: skip
    assert [table.mass_per_area(r) for r in (0.2, 0.4, 0.6, 0.9)] == pytest.approx([2, 4, 6, 6])
    assert table.without_mass().mass_per_area(0.4) == pytest.approx(4)
    assert reading(**{F: [1, 2, 3], C: 5.0, PARTICLES: 0.7}).mass_per_area(0.5) == 0.7
    assert np.isnan(reading(**{F: 100.0, C: 5.0, M: 2.0}).mass_per_area(0.5))
    assert reading(**{F: 100.0, C: 5.0, PARTICLES: 2.0}).mass_per_area(np.nan) == 2


def test_the_mass_of_a_loss_factor_is_that_of_the_fill():
    table = reading(**{"fill_fraction": [0.2, 0.6], F: 100.0, "loss_factor": 0.1,
                       PARTICLES: [2.0, 6.0]})  # fmt: skip
    found = at(table, 100.0, fill=0.4).equivalent_damping[0]
    assert found == pytest.approx(0.1 * 4.0 * 2 * np.pi * 100.0)


def test_without_mass_only_errors_of_damping_are_left():
    with_both = reading(**{F: [50, 500], C: [5.0, 9.0], M: 1.0, M_ERROR: 0.1, C_ERROR: 1.0})
    assert with_both.without_mass().nodes is not None
    only_mass = reading(**{F: 100.0, C: 5.0, M: 1.0, M_ERROR: 0.1})
    assert only_mass.nodes is not None and only_mass.without_mass().nodes is None


# ------------------------------------------------------------------------ errors


def test_errors_are_those_of_the_table():
    table = reading(**{F: [100, 400], C: [10.0, 40.0], C_ERROR: [1.0, 8.0], M: 2.0, M_ERROR: 0.3})
    found = at(table, [100, 400])
    np.testing.assert_allclose(found.equivalent_damping_error, [1.0, 8.0])
    f = np.array([100.0, 400.0])
    np.testing.assert_array_equal(table.nodes, f)
    covariance = table.covariance(f, 0.5, 1.0)
    error = np.array([0.1, 0.2, 0.3, 0.3])
    expected = np.outer(error, error)
    expected[:2, 2:] = expected[2:, :2] = 0
    np.testing.assert_allclose(covariance, expected)


def test_errors_of_a_loss_factor_and_of_an_impedance_become_those_of_damping_and_mass():
    f, omega = np.array([100.0]), 200 * np.pi
    eta = reading(**{F: 100.0, "loss_factor": 0.2, "loss_factor_error": 0.05, PARTICLES: 3.0})
    assert np.sqrt(eta.covariance(f, 0.5, 1.0)[0, 0]) == pytest.approx(0.25)
    assert at(eta, f).equivalent_damping_error[0] == pytest.approx(0.05 * 3 * omega)
    z = reading(**{F: 100.0, "impedance_real_n_s_m3": 8.0, "impedance_real_error_n_s_m3": 2.0,
                   "impedance_imag_n_s_m3": 50.0, "impedance_imag_error_n_s_m3": 5.0})  # fmt: skip
    np.testing.assert_allclose(np.sqrt(np.diag(z.covariance(f, 0.5, 1.0))), [0.25, 5 / omega])


def test_two_points_of_a_table_err_together():
    table = reading(**{F: [100, 100], "acceleration_g": [1.0, 9.0], C: 10.0, C_ERROR: [1.0, 3.0]})
    f = np.array([100.0])
    cross = table.cross_covariance(f, (0.5, 1.0), (0.5, 9.0))
    assert cross[0, 0] == pytest.approx(0.1 * 0.3)
    joint = np.array([[0.01, cross[0, 0]], [cross[0, 0], 0.09]])
    assert np.linalg.eigvalsh(joint).min() > -1e-15  # of rank one: rounding alone


def test_a_table_without_errors_has_none():
    assert reading(**{F: [1, 2], C: 5.0, C_ERROR: [0.0, 0.1]}).nodes is not None
    assert reading(**{F: [1, 2], C: 5.0}).nodes is None
    assert reading(**{F: [1, 2], C: 5.0, C_ERROR: 0.0}).nodes is None
    assert (reading(**{F: [1, 2], C: 5.0}).covariance(np.ones(1), 1.0, 1.0) == 0).all()


# ------------------------------------------------------------------------ our own


def surface():
    rng = np.random.default_rng(4)
    r, f, level = (
        g.ravel() for g in np.meshgrid([0.1, 0.5, 0.9], [30.0, 200.0, 900.0], [2.0, 20.0, 200.0])
    )
    value = r * f * level**-0.5 * np.exp(0.1 * rng.normal(size=27))
    frame = pd.DataFrame({"fill_fraction": r, F: f, "acceleration_g": level, C: value,
                          C_ERROR: 0.05 * value, M: r * 5, M_ERROR: 0.1, PARTICLES: 13 * r})  # fmt: skip
    # without its corner of high frequency and low motion: the grid is not full
    return DampingSurface.from_frame(frame[(f < 900) | (level > 2)])


def test_our_own_csv_is_a_table_of_its_rows(tmp_path):
    path = tmp_path / "surface.csv"
    of_cases = surface()
    to_frame(of_cases).to_csv(path, index=False, float_format="%.6g")
    table, rows = read_table(path), pd.read_csv(path)
    assert 0 < len(rows) < 5 * 9 * 7
    for row in rows.itertuples():
        found = at(table, row.frequency_hz, row.fill_fraction, row.acceleration_g)
        assert found.inside.all()
        # the ratio of error and value, times the value: one rounding each
        assert found.equivalent_damping[0] == row.equivalent_damping_n_s_m3
        assert found.apparent_mass[0] == row.apparent_mass_kg_m2
        assert found.equivalent_damping_error[0] == pytest.approx(
            row.equivalent_damping_error_n_s_m3, rel=1e-15
        )
    inside = of_cases.simulated.contains(rows[["fill_fraction", F, "acceleration_g"]].to_numpy())
    # on the edge but for the sixth digit
    assert inside.mean() > 0.5
    assert table.mass_per_area(0.5) == pytest.approx(6.5, rel=1e-5)
    assert set(read_columns(path)) == set(rows.columns)
