"""Truths of the closed forms, and of the orders given to computed modes."""

import dataclasses

import numpy as np
import pytest

from pidpanel.panel.navier import (
    mode_orders,
    sandwich_frequency,
    sine_shapes,
    thin_plate_frequency,
)

SIZE = (1.5, 1.0)


def test_closed_form_of_the_thin_plate_is_table_1():
    table = {(1, 1): 64.90, (1, 2): 199.70, (4, 2): 499.26, (6, 4): 1437.87, (9, 1): 1662.53}
    m, n = np.array(list(table)).T
    # the table is rounded to 0.01 Hz; D / m'' is known to 0.005 %
    np.testing.assert_allclose(
        thin_plate_frequency(m, n, SIZE, 3273.07, 4.0), list(table.values()), rtol=1e-4
    )


def test_sandwich_bends_and_shears_in_series():
    D, S, mass = 6034.15, 3.0e6, 1.7408
    for m, n in [(1, 1), (3, 2), (9, 7)]:
        k = np.hypot(m * np.pi / 1.5, n * np.pi / 1.0)
        # springs in series per unit area: D k^4 of bending and S k^2 of shear
        stiffness = 1 / (1 / (D * k**4) + 1 / (S * k**2))
        expected = np.sqrt(stiffness / mass) / (2 * np.pi)
        assert sandwich_frequency(m, n, SIZE, D, S, mass) == pytest.approx(expected, rel=1e-12)


def test_sines_vanish_on_the_edges_and_have_their_half_waves():
    position = np.array([[0.0, 0.3], [1.5, 0.3], [0.2, 0.0], [0.2, 1.0], [0.25, 0.5], [0.75, 0.5]])
    shapes = sine_shapes([3, 2], [1, 1], SIZE, position)
    expected = [[0, 0], [0, 0], [0, 0], [0, 0], [1, np.sqrt(0.75)], [-1, 0]]
    np.testing.assert_allclose(shapes, expected, atol=1e-12)


def test_orders_are_right_for_all_modes_below_3_khz(paper_basis):
    orders, share = mode_orders(paper_basis, SIZE)
    exact = thin_plate_frequency(orders[:, 0], orders[:, 1], SIZE, 3273.07, 4.0)
    frequency = paper_basis.natural_frequency[: len(orders)]
    # the element's error, (kh)^4 / 1440 of up to 0.17 % for twelve half waves
    np.testing.assert_allclose(frequency, exact, rtol=2e-3)
    m, n = np.mgrid[1:40, 1:40]
    below = 44.9332 * (m**2 / 2.25 + n**2) < 3000
    assert {tuple(o) for o in orders} == set(zip(m[below], n[below], strict=True))
    assert share.min() > 0.9999


def with_pair(basis, change):
    """The basis with the shapes of (3, 4) and (6, 2) changed, and their two numbers."""
    orders, _ = mode_orders(basis, SIZE)
    pair = [np.flatnonzero((orders == order).all(axis=1)).item() for order in [(3, 4), (6, 2)]]
    shapes = basis.shape_at_quadrature.copy()
    shapes[:, pair] = shapes[:, pair] @ change
    return dataclasses.replace(basis, shape_at_quadrature=shapes), pair


def test_orders_of_a_pair_survive_a_turn_in_its_subspace(paper_basis):
    turned, pair = with_pair(paper_basis, np.array([[1, 1], [1, -1]]))
    orders, share = mode_orders(turned, SIZE)
    assert {tuple(order) for order in orders[pair]} == {(3, 4), (6, 2)}
    assert share.min() > 0.9999


def test_orders_of_a_pair_follow_the_shapes_not_the_frequencies(paper_basis):
    swapped, pair = with_pair(paper_basis, np.array([[0, 1], [1, 0]]))
    orders, _ = mode_orders(swapped, SIZE)
    assert orders[pair].tolist() == [[6, 2], [3, 4]]


def test_shapes_that_are_no_sines_of_the_rectangle_have_a_low_share(paper_basis):
    _, share = mode_orders(paper_basis, (1.7, 1.1))
    assert share.min() < 0.9
