"""Cases to start with and cases to come: rules held to their words."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping import design
from pidpanel.damping.sides import Sides
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import ERROR, VALUE

GRID = np.stack(
    [
        g.ravel()
        for g in np.meshgrid(np.linspace(0.3, 0.34, 5), np.geomspace(30, 2000, 5),
                             np.geomspace(4, 400, 5), indexing="ij")
    ],
    axis=1,
)  # fmt: skip


@pytest.fixture(scope="module")
def surface():
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
def test_a_case_takes_away_the_variance_of_c_e_and_of_m_a_each_with_its_own_noise(surface, of):
    # red: p.scatter**2 → p.scatter * 2, or the median error to the first power, in `gains`
    n = len(surface.nodes)
    weight = np.exp(-(np.log(surface.nodes / 300) ** 2) / 0.2)
    derivative = np.zeros((2 * n, 1))
    derivative[of * n : (of + 1) * n, 0] = weight
    one = design.Wanted(0.5, 40.0, derivative)
    (before,) = design.variances(surface, [one])
    (gain,) = design.gains(surface, [one], CASE, 0.2)
    (left,) = design.variances(surface.with_case(CASE, 0.2), [one])
    # the width of the prior of the mean goes by the spread of the values, which one more alters
    assert before[0] - left[0] == pytest.approx(gain[0, 0], rel=0.02)


def reading(surface, at, size):
    weight = size * np.exp(-(np.log(surface.nodes / at) ** 2) / 0.2)
    return design.Wanted(0.5, 40.0, np.concatenate([weight, 0 * weight])[:, None])


def test_it_is_shares_of_variances_that_count_not_their_sizes(surface):
    # red: gain[:, over] / variance[over] → * in `next_cases`
    pool = np.add(GRID, [0.15, 0, 0])
    chosen = [
        design.next_cases(
            surface, [reading(surface, 60, size), reading(surface, 900, 1)], pool, 0.05, 1e-9, 3
        )
        for size in (1.0, 100.0, 0.01)
    ]
    assert chosen[0] == chosen[1] == chosen[2]
    assert len(set(chosen[0])) == 3


def test_one_quantity_above_its_target_is_reason_enough_and_the_only_one_that_counts(surface):
    # red: over.any() → over.all() in `next_cases`
    pool = np.add(GRID, [0.15, 0, 0])
    low, high = reading(surface, 60, 1e-9), reading(surface, 900, 1.0)
    both = replace(high, derivative=np.hstack([low.derivative, high.derivative]))
    alone = design.next_cases(surface, [high], pool, 0.05, 1e-4, 2)
    assert design.next_cases(surface, [both], pool, 0.05, 1e-4, 2) == alone
    assert len(alone) == 2


def test_slices_nearly_alike_are_one_with_the_quantities_of_both(surface):
    # red: ALIKE = 0; the derivative of the first alone
    first, other = reading(surface, 60, 1.0), reading(surface, 900, 2.0)
    near = replace(other, acceleration_g=40.0 * 1.02)
    far = replace(other, acceleration_g=40.0 * 1.04)
    fill = replace(other, fill_fraction=0.6)
    found = design.distinct([first, near, far, fill])
    assert [one.derivative.shape[1] for one in found] == [2, 1, 1]
    np.testing.assert_array_equal(
        found[0].derivative, np.hstack([first.derivative, near.derivative])
    )


def test_tones_of_a_slice_are_at_its_nodes_and_slow_enough(surface):
    # red: speed ≥ fastest; f rounded to two digits
    one = reading(surface, 300, 1.0)
    points, _ = design.slice_points(surface, one, None)
    assert len(points) == len(surface.nodes)
    np.testing.assert_allclose(points[:, 1], surface.nodes, rtol=5e-3)
    assert (points[:, 0] == 0.5).all() and (points[:, 2] == 40.0).all()
    slow, kept = design.slice_points(surface, one, 0.5)
    assert slow[:, 1].min() >= 40 * 9.80665 / (2 * np.pi * 0.5) > points[:, 1].min()
    np.testing.assert_array_equal(points[kept], slow)
    still, _ = design.slice_points(surface, replace(one, acceleration_g=0.9), None)
    assert len(still) == 0


def test_damping_along_a_slice_counts_at_each_of_its_nodes(surface):
    # the variance of an added quantity is that of ln C_e at its node, times the scale squared
    # red: along[node] = scale for every column
    one, n = reading(surface, 300, 1.0), len(surface.nodes)
    node = np.array([0, 7])
    more = design.with_damping_along(one, node, 0.3)
    (variance,) = design.variances(surface, [more])
    own = np.diag(surface.covariance(surface.nodes, 0.5, 40.0))[:n]
    np.testing.assert_allclose(variance[1:], 0.09 * own[node])
    np.testing.assert_allclose(variance[:1], design.variances(surface, [one])[0])
