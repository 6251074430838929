"""Which cases to run next: what is foretold of them comes true."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping.sides import Sides
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import ERROR, VALUE
from pidpanel.damping.thinned import spread_out
from pidpanel.sampling import choice as design

POOL = np.stack(
    [
        g.ravel()
        for g in np.meshgrid([0.1, 0.5, 0.9], np.geomspace(30, 2000, 6), [4.0, 40.0, 400.0],
                             indexing="ij")
    ],
    axis=1,
)  # fmt: skip


def run(points):
    """Cases of a law with a bend, known to 5 %."""
    r, f, level = points.T
    value = 50 * r * f * level**-0.8 * (1 + 300 * level / f**2) ** 0.4
    return pd.DataFrame(
        {"fill_fraction": r, "frequency_hz": f, "acceleration_g": level, VALUE: value,
         ERROR: 0.05 * value, "apparent_mass_kg_m2": 0.3 * r * np.log(level),
         "apparent_mass_error_kg_m2": 0.01 * np.ones_like(r)}
    )  # fmt: skip


def spread(count):
    """Numbers of cases that are spread over the sweep."""
    at = np.column_stack([POOL[:, 0], np.log(POOL[:, 1:])])
    return spread_out(at / np.ptp(at, axis=0), count).tolist()


@pytest.fixture(scope="module")
def surface():
    return DampingSurface.from_frame(run(POOL[spread(14)]))


def wanted(surface, fill=0.5, level=40.0, at=300.0):
    """Something that reads C_e round one frequency, and m_a a little."""
    weight = np.exp(-(np.log(surface.nodes / at) ** 2) / 0.2)
    return design.Demand(fill, level, np.concatenate([0.1 * weight, 0.01 * weight])[:, None])


def test_the_variance_taken_away_is_the_variance_that_is_gone(surface):
    one = wanted(surface)
    (before,) = design.variances(surface, [one])
    (gain,) = design.gains(surface, [one], POOL[[25]], 0.05)
    after = surface.with_case(POOL[[25]], 0.05)
    (left,) = design.variances(after, [one])
    # the width of the prior of the mean goes by the spread of the values, which one more alters
    assert before[0] - left[0] == pytest.approx(gain[0, 0], rel=0.03)
    assert gain[0, 0] > 0


def test_the_case_chosen_lies_where_it_is_read(surface):
    (first, *_) = design.next_cases(surface, [wanted(surface)], POOL, 0.05, 1e-4, 1)
    r, f, level = POOL[first]
    assert r == 0.5 and level == 40.0
    assert abs(np.log(f / 300)) < np.log(2.4)  # the run points stand a factor 2.3 apart


def test_a_batch_holds_no_case_twice_and_ends_where_the_target_is_met(surface):
    one = wanted(surface)
    batch = design.next_cases(surface, [one], POOL, 0.05, 1e-4, 6)
    assert len(set(batch)) == 6
    (variance,) = design.variances(surface, [one])
    assert design.next_cases(surface, [one], POOL, 0.05, 1.01 * variance[0] ** 0.5, 6) == []


def test_chosen_cases_narrow_it_more_than_cases_spread_evenly(surface):
    one = wanted(surface)
    start = spread(14)
    left = [i for i in range(len(POOL)) if i not in start]
    chosen = design.next_cases(surface, [one], POOL[left], 0.05, 1e-4, 4)
    even = [i for i in spread(18) if i not in start][:4]
    found = [
        design.variances(DampingSurface.from_frame(run(POOL[start + more])), [one])[0][0]
        for more in ([left[i] for i in chosen], even)
    ]
    assert found[0] < 0.5 * found[1]


GRID = np.stack(
    [
        g.ravel()
        for g in np.meshgrid(np.linspace(0.3, 0.34, 5), np.geomspace(30, 2000, 5),
                             np.geomspace(4, 400, 5), indexing="ij")
    ],
    axis=1,
)  # fmt: skip


@pytest.fixture(scope="module")
def scattered():
    """A surface whose C_e and m_a scatter by more than the errors of its cases."""
    rng = np.random.default_rng(2)
    r, f, level = np.stack(
        [rng.uniform(0.1, 0.9, 40), np.exp(rng.uniform(3.5, 7.5, 40)),
         np.exp(rng.uniform(1.5, 6, 40))]
    )  # fmt: skip
    value = 50 * r * f * level**-0.8
    mass = r * (0.3 * np.log(level) + 2 + 0.4 * rng.normal(size=40))
    found = DampingSurface.from_frame(
        pd.DataFrame(
            {"fill_fraction": r, "frequency_hz": f, "acceleration_g": level, VALUE: value,
             ERROR: 0.05 * value, "apparent_mass_kg_m2": mass,
             "apparent_mass_error_kg_m2": 0.3 * r}
        )
    )  # fmt: skip
    return DampingSurface(
        found.cases,
        found.bed,
        Sides(replace(found.damping.riding, scatter=0.3)),
        Sides(replace(found.mass.riding, scatter=0.25)),
    )


CASE = np.array([[0.5, 300.0, 40.0]])


@pytest.mark.parametrize("of", [0, 1])
def test_a_case_takes_away_the_variance_of_c_e_and_of_m_a_each_with_its_own_noise(scattered, of):
    # red: p.scatter**2 → p.scatter * 2, or the median error to the first power, in `gains`
    n = len(scattered.nodes)
    weight = np.exp(-(np.log(scattered.nodes / 300) ** 2) / 0.2)
    derivative = np.zeros((2 * n, 1))
    derivative[of * n : (of + 1) * n, 0] = weight
    one = design.Demand(0.5, 40.0, derivative)
    (before,) = design.variances(scattered, [one])
    (gain,) = design.gains(scattered, [one], CASE, 0.2)
    (left,) = design.variances(scattered.with_case(CASE, 0.2), [one])
    # the width of the prior of the mean goes by the spread of the values, which one more alters
    assert before[0] - left[0] == pytest.approx(gain[0, 0], rel=0.02)


def reading(scattered, at, size):
    weight = size * np.exp(-(np.log(scattered.nodes / at) ** 2) / 0.2)
    return design.Demand(0.5, 40.0, np.concatenate([weight, 0 * weight])[:, None])


def test_it_is_shares_of_variances_that_count_not_their_sizes(scattered):
    # red: gain[:, over] / variance[over] → * in `next_cases`
    pool = np.add(GRID, [0.15, 0, 0])
    chosen = [
        design.next_cases(
            scattered,
            [reading(scattered, 60, size), reading(scattered, 900, 1)],
            pool,
            0.05,
            1e-9,
            3,
        )
        for size in (1.0, 100.0, 0.01)
    ]
    assert chosen[0] == chosen[1] == chosen[2]
    assert len(set(chosen[0])) == 3


def test_one_quantity_above_its_target_is_reason_enough_and_the_only_one_that_counts(
    scattered,
):
    # red: over.any() → over.all() in `next_cases`
    pool = np.add(GRID, [0.15, 0, 0])
    low, high = reading(scattered, 60, 1e-9), reading(scattered, 900, 1.0)
    both = replace(high, derivative=np.hstack([low.derivative, high.derivative]))
    alone = design.next_cases(scattered, [high], pool, 0.05, 1e-4, 2)
    assert design.next_cases(scattered, [both], pool, 0.05, 1e-4, 2) == alone
    assert len(alone) == 2


def test_slices_nearly_alike_are_one_with_the_quantities_of_both(scattered):
    # red: ALIKE = 0; the derivative of the first alone
    first, other = reading(scattered, 60, 1.0), reading(scattered, 900, 2.0)
    near = replace(other, acceleration_g=40.0 * 1.02)
    far = replace(other, acceleration_g=40.0 * 1.04)
    fill = replace(other, fill_fraction=0.6)
    found = design.distinct([first, near, far, fill])
    assert [one.derivative.shape[1] for one in found] == [2, 1, 1]
    np.testing.assert_array_equal(
        found[0].derivative, np.hstack([first.derivative, near.derivative])
    )


def test_tones_of_a_slice_are_at_its_nodes_and_slow_enough(scattered):
    # red: speed ≥ fastest; f rounded to two digits
    one = reading(scattered, 300, 1.0)
    points, _ = design.slice_points(scattered, one, None)
    assert len(points) == len(scattered.nodes)
    np.testing.assert_allclose(points[:, 1], scattered.nodes, rtol=5e-3)
    assert (points[:, 0] == 0.5).all() and (points[:, 2] == 40.0).all()
    slow, kept = design.slice_points(scattered, one, 0.5)
    assert slow[:, 1].min() >= 40 * 9.80665 / (2 * np.pi * 0.5) > points[:, 1].min()
    np.testing.assert_array_equal(points[kept], slow)
    still, _ = design.slice_points(scattered, replace(one, acceleration_g=0.9), None)
    assert len(still) == 0


def test_damping_along_a_slice_counts_at_each_of_its_nodes(scattered):
    # the variance of an added quantity is that of ln C_e at its node, times the scale squared
    # red: along[node] = scale for every column
    one, n = reading(scattered, 300, 1.0), len(scattered.nodes)
    node = np.array([0, 7])
    more = design.with_damping_along(one, node, 0.3)
    (variance,) = design.variances(scattered, [more])
    own = np.diag(scattered.covariance(scattered.nodes, 0.5, 40.0))[:n]
    np.testing.assert_allclose(variance[1:], 0.09 * own[node])
    np.testing.assert_allclose(variance[:1], design.variances(scattered, [one])[0])
