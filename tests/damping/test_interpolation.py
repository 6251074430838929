"""Interpolation between rows: exact at them, constant between equal ones, without a jump."""

import itertools

import numpy as np
import pytest
from hypothesis import example, given
from hypothesis import strategies as st

from pidpanel.damping.interpolation import Interpolator, inner_axis, lone_rows

KINDS = ("log", "linear")
FILLS, AMPLITUDES, FREQUENCIES = (0.1, 0.4, 0.9), (0.3, 1.0, 7.0, 50.0), (20.0, 90.0, 1500.0)


def grid():
    return np.array(list(itertools.product(FILLS, AMPLITUDES, FREQUENCIES))).T


def ask(rows, points):
    values, inside = rows(*np.atleast_2d(points).T)
    return values[:, 0], inside


@st.composite
def tables(draw):
    """Rows at some points of a grid, each once, with values that may be zero."""
    points = draw(st.lists(st.sampled_from(list(grid().T.tolist())), min_size=1, unique_by=tuple))
    value = st.one_of(st.just(0.0), st.floats(1e-3, 1e5))
    return np.array(points), np.array([[draw(value)] for _ in points])


@pytest.mark.slow
@example((np.array([(1.0, 1.0, 20.0), (1.0, 1.0, 90.0)]), np.array([[49.0], [1.0]])), "log")
@given(tables(), st.sampled_from(KINDS))
def test_any_table_says_at_its_rows_what_it_says(table, kind):
    # 49 · (1/49) is not 1
    points, values = table
    found, inside = ask(Interpolator(*points.T, values, kind), points)
    np.testing.assert_array_equal(found, values[:, 0])
    assert inside.all()


@pytest.mark.slow
@given(tables(), st.sampled_from(KINDS), st.floats(0, 1e6),
       st.tuples(st.floats(0.01, 1), st.floats(0.01, 1e3), st.floats(1, 1e4)))  # fmt: skip
def test_any_table_of_one_value_says_it_everywhere(table, kind, value, point):
    points, values = table
    found, _ = ask(Interpolator(*points.T, np.full_like(values, value), kind), point)
    assert found == value


@pytest.mark.slow
@given(tables(), st.sampled_from(KINDS),
       st.tuples(st.floats(0.01, 1), st.floats(0.01, 1e3), st.floats(1, 1e4)))  # fmt: skip
def test_nothing_is_said_beyond_the_least_and_the_most_of_the_rows(table, kind, point):
    points, values = table
    found, _ = ask(Interpolator(*points.T, values, kind), point)
    # rounding of first·(second/first)^weight
    assert values.min() * (1 - 1e-12) <= found[0] <= values.max() * (1 + 1e-12)


@pytest.mark.slow
@given(tables(), st.sampled_from(KINDS), st.integers(0, 2),
       st.tuples(st.floats(0.05, 1), st.floats(0.1, 100), st.floats(10, 3000)))  # fmt: skip
def test_values_have_no_jump(table, kind, axis, point):
    # two points 1e-9 apart: at most that times the steepest slope between rows, 1e5 over the step
    # of the amplitude from 0.3 to 1 seen from 100: 143 times 1e5
    # to zero drags its neighbours with it at that one point
    points, values = table
    beside = np.array(point)
    beside[axis] *= 1 + 1e-9
    rows = Interpolator(*points.T, values, kind)
    (one, _), (other, _) = ask(rows, point), ask(rows, beside)
    assert abs(one - other) <= 1e-9 * 1e5 * 143


@pytest.mark.parametrize("kind", KINDS)
def test_a_full_grid_is_interpolated_multilinearly(kind):
    # against the eight corners with their weights, written out
    axes = (FILLS, AMPLITUDES, FREQUENCIES)
    rng = np.random.default_rng(2)
    values = np.exp(rng.normal(size=(36, 1)))
    rows = Interpolator(*grid(), values, kind)
    cube = values.reshape(3, 4, 3)
    log = kind == "log"
    for point in rng.uniform([0.1, 0.3, 20], [0.9, 50, 1500], (200, 3)):
        total = 0.0
        places = []
        for x, at, curved in zip(point, axes, (False, log, log), strict=True):
            scale = np.log if curved else np.asarray
            i = int(np.sum(np.array(at[1:-1]) <= x))
            w = (scale(x) - scale(at[i])) / (scale(at[i + 1]) - scale(at[i]))
            places.append(((i, 1 - w), (i + 1, w)))
        for corner in itertools.product(*places):
            value = cube[tuple(i for i, _ in corner)]
            total += np.prod([w for _, w in corner]) * (np.log(value) if log else value)
        found, inside = ask(rows, point)
        assert inside.all()
        np.testing.assert_allclose(found[0], np.exp(total) if log else total, rtol=1e-10)


def test_a_power_law_on_lines_of_their_own_frequencies_is_found_between_them():
    # C = f^0.7 a^-0.4, straight in logarithms: exact though no two lines share a frequency
    lines = {1.0: (50.0, 130.0, 400.0), 8.0: (60.0, 350.0), 30.0: (20.0, 90.0, 500.0)}
    points = np.array([(0.5, a, f) for a, at in lines.items() for f in at])
    values = points[:, 2:] ** 0.7 * points[:, 1:2] ** -0.4
    rows = Interpolator(*points.T, values, "log")
    asked = np.array([(0.5, 2.0, 61.0), (0.5, 5.0, 300.0), (0.5, 20.0, 349.0)])
    found, inside = ask(rows, asked)
    np.testing.assert_allclose(found, asked[:, 2] ** 0.7 * asked[:, 1] ** -0.4, rtol=1e-12)
    assert inside.all()


def test_rows_that_share_frequencies_only_are_lines_along_the_amplitude():
    # a sine test at set frequencies, whose amplitudes come as they come
    measured = {50.0: (1.02, 9.7, 31.0), 100.0: (0.97, 10.4, 29.0), 200.0: (1.1, 8.8, 33.0)}
    points = np.array([(0.5, a, f) for f, at in measured.items() for a in at])
    values = points[:, 2:] ** 0.7 * points[:, 1:2] ** -0.4
    assert inner_axis(*points.T) == 1
    found, inside = ask(Interpolator(*points.T, values, "log"), (0.5, 5.0, 70.0))
    np.testing.assert_allclose(found, 70.0**0.7 * 5.0**-0.4, rtol=1e-12)
    assert inside.all()
    assert len(lone_rows(*points.T)) == 0


@pytest.mark.parametrize("kind", KINDS)
def test_what_rounding_puts_beyond_the_rows_is_inside_and_no_more(kind):
    # a billionth of a step
    rows = Interpolator(np.ones(2), np.ones(2), np.array([100.0, 200.0]), np.ones((2, 1)), kind)
    for frequency in (100 * (1 - 1e-12), 200 * (1 + 1e-12)):
        assert ask(rows, (1.0, 1.0, frequency))[1].all()
        assert ask(rows, (1.0 + 1e-12, 1.0, frequency))[1].all()
    for frequency in (100 * (1 - 1e-8), 200 * (1 + 1e-8)):
        assert not ask(rows, (1.0, 1.0, frequency))[1].any()
    for fill in (1.0 - 1e-8, 1.0 + 1e-8):
        assert not ask(rows, (fill, 1.0, 150.0))[1].any()


@pytest.mark.parametrize(
    ("point", "held", "inside"),
    [
        ((0.5, 10.0, 100.0), 20.0, True),
        ((0.5, 10.0, 50.0), 20.0, False),
        ((0.5, 10.0, 900.0), 40.0, False),
        ((0.5, 99.0, 100.0), 5.0, False),
        ((0.5, 1.0, 100.0), 20.0, False),
        ((0.9, 10.0, 100.0), 20.0, False),
        ((0.2, 10.0, 100.0), 20.0, False),
    ],
)
@pytest.mark.parametrize("kind", KINDS)
def test_beyond_the_rows_values_are_held_and_marked(kind, point, held, inside):
    points = np.array([(0.5, a, f) for a in (10.0, 40.0) for f in (100.0, 400.0)])
    rows = Interpolator(*points.T, np.array([[20.0], [40.0], [5.0], [7.0]]), kind)
    (found,), (within,) = ask(rows, point)
    assert (found, within) == (held, inside)


def test_between_a_short_and_a_long_line_it_is_outside_where_the_short_one_ends():
    points = np.array([(0.5, 1.0, 50.0), (0.5, 1.0, 900.0), (0.5, 9.0, 50.0), (0.5, 9.0, 200.0)])
    rows = Interpolator(*points.T, np.ones((4, 1)), "log")
    asked = [(0.5, 3.0, 150.0), (0.5, 3.0, 300.0), (0.5, 1.0, 300.0), (0.5, 9.0, 300.0)]
    assert ask(rows, asked)[1].tolist() == [True, False, True, False]


def test_a_fill_of_one_amplitude_holds_for_every_amplitude():
    points = np.array([(0.2, 5.0, 50.0), (0.2, 5.0, 90.0), (0.6, 8.0, 50.0), (0.6, 8.0, 90.0)])
    rows = Interpolator(*points.T, np.array([[1.0], [1.0], [4.0], [4.0]]), "log")
    assert not rows.depends_on_amplitude
    more = np.vstack([points, [0.6, 9.0, 50.0]])
    assert Interpolator(*more.T, np.ones((5, 1)), "log").depends_on_amplitude
    (found,), (inside,) = ask(rows, (0.4, 1e3, 70.0))
    assert found == pytest.approx(2.0) and inside


def test_zeros_are_left_along_straight_lines():
    # 0 to 10 between 100 and 400 Hz: half of it at the middle of the logarithm; 10 to 40 beyond:
    # the geometric mean.
    points = np.array([(1.0, 1.0, f) for f in (100.0, 400.0, 1600.0)])
    rows = Interpolator(*points.T, np.array([[0.0], [10.0], [40.0]]), "log")
    found, _ = ask(rows, [(1.0, 1.0, 200.0), (1.0, 1.0, 800.0)])
    np.testing.assert_allclose(found, [5.0, 20.0])
    # from line to line: logarithmic only where neither line has a zero
    lines = np.array([(1.0, a, f) for a in (1.0, 4.0, 16.0) for f in (100.0, 400.0, 900.0)])
    values = np.array([[0.0], [10.0], [10.0], *[[40.0]] * 3, *[[90.0]] * 3])
    found, _ = ask(Interpolator(*lines.T, values, "log"), [(1.0, 2.0, 400.0), (1.0, 8.0, 400.0)])
    np.testing.assert_allclose(found, [25.0, 60.0])
