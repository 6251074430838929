"""Of very many cases those enter a surface that are spread over all of them."""

import numpy as np
import pandas as pd

from pidpanel.damping import surface_cases
from pidpanel.damping.surface import DampingSurface


def test_few_points_are_all_taken():
    points = np.random.default_rng(1).random((7, 3))
    assert surface_cases.spread_out(points, 7).tolist() == list(range(7))


def test_the_first_that_is_taken_is_farthest_from_the_middle():
    points = np.array([[0.0], [1.0], [2.1], [3.0], [4.5]])
    assert surface_cases.spread_out(points, 1).tolist() == [4]


def test_points_that_are_taken_leave_none_far_away():
    points = np.random.default_rng(2).random((4000, 2))
    taken = points[surface_cases.spread_out(points, 100)]
    away = np.sqrt(((points[:, None] - taken) ** 2).sum(axis=2))
    # twice the radius of 100 discs that could cover a unit square, hexagons without overlap
    most = 2 * np.sqrt(2 / (3 * np.sqrt(3) * 100))
    assert away.min(axis=1).max() < most
    between = np.sqrt(((taken[:, None] - taken) ** 2).sum(axis=2)) + 9 * np.eye(100)
    assert between.min() >= away.min(axis=1).max() - 1e-9


def frame(count):
    rng = np.random.default_rng(3)
    fill, f, gamma = rng.uniform([[0.1], [20], [2]], [[0.9], [500], [99]], (3, count))
    value = 9 * fill * f * gamma**-0.3 * (1 - gamma**-2)
    value *= np.exp(0.03 * rng.standard_normal(count))
    columns = [*surface_cases.AXES, surface_cases.VALUE, surface_cases.ERROR]
    return pd.DataFrame(np.column_stack([fill, f, gamma, value, 0.01 * fill * f]), columns=columns)


def test_a_surface_of_very_many_cases_is_bounded_and_reads_what_they_say(monkeypatch):
    cases = frame(5000).sort_values("frequency_hz", ignore_index=True)
    monkeypatch.setattr(surface_cases, "MOST_CASES", 120)
    counted, _ = surface_cases.counted(cases, 1.0)
    assert len(counted) == 120
    axes = list(surface_cases.AXES)
    np.testing.assert_allclose(np.log(counted[axes]).min(), np.log(cases[axes]).min(), atol=0.2)
    np.testing.assert_allclose(np.log(counted[axes]).max(), np.log(cases[axes]).max(), atol=0.2)
    surface = DampingSurface.from_frame(cases)
    left_out = frame(50)
    read = surface.evaluate(*(left_out[axis] for axis in axes))
    away = np.log(read.equivalent_damping / left_out["equivalent_damping_n_s_m3"])
    size = read.equivalent_damping_error / read.equivalent_damping
    assert np.sqrt(np.mean(away**2)) < 0.06
    assert np.mean(np.abs(away) < 2 * size) > 0.85
