"""Truths of the closed forms, and of the orders given to computed modes."""

import dataclasses

import numpy as np
import pytest

from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.navier import mode_orders, sine_shapes, thin_plate_frequency
from pidpanel.panel.section import ThinSection

SIZE = (1.5, 1.0)


def test_closed_form_of_the_thin_plate_is_table_1():
    table = {(1, 1): 64.90, (1, 2): 199.70, (4, 2): 499.26, (6, 4): 1437.87, (9, 1): 1662.53}
    m, n = np.array(list(table)).T
    # the table is rounded to 0.01 Hz; D / m'' is known to 0.005 %
    np.testing.assert_allclose(
        thin_plate_frequency(m, n, SIZE, ThinSection(3273.07, 4.0)), list(table.values()), rtol=1e-4
    )


def test_orders_are_right_for_all_modes_below_3_khz(paper_basis):
    orders, share = mode_orders(paper_basis, SIZE)
    exact = thin_plate_frequency(orders[:, 0], orders[:, 1], SIZE, ThinSection(3273.07, 4.0))
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


def made_of_sines(size, orders, frequency, change=None):
    """A basis whose modes are sines of a rectangle, times a matrix; the rest of it is empty."""
    node, weight = np.polynomial.legendre.leggauss(24)
    x, y = np.meshgrid(*(side * (node + 1) / 2 for side in size), indexing="ij")
    position = np.stack([x.ravel(), y.ravel()], axis=1)
    shapes = sine_shapes(*np.array(orders).T, size, position)
    filled = {
        "natural_frequency": np.array(frequency, dtype=float),
        "is_residual": np.zeros(len(frequency), dtype=bool),
        "quadrature_position": position,
        "quadrature_weight": np.outer(weight, weight).ravel() * size[0] * size[1] / 4,
        "shape_at_quadrature": shapes if change is None else shapes @ np.array(change),
    }
    return PanelBasis(**{f.name: filled.get(f.name) for f in dataclasses.fields(PanelBasis)})


@pytest.mark.parametrize("size", [(20.0, 1.0), (1.0, 20.0)])
def test_the_modes_of_a_strip_have_their_half_waves_along_it(size):
    along = [(k, 1) if size[0] > 1 else (1, k) for k in (1, 2, 3, 4)]
    orders, share = mode_orders(made_of_sines(size, along, [10, 20, 30, 40]), size)
    assert orders.tolist() == [list(order) for order in along]
    np.testing.assert_allclose(share, 1.0, rtol=1e-12)


def test_a_share_is_the_energy_of_the_sine_in_the_mode():
    # (1, 1) with half of (2, 1) beside it: 1/(1 + 1/4) of the sine lies in the mode
    mixed = made_of_sines(SIZE, [(1, 1), (2, 1)], [60, 120], [[1, 0], [0.5, 1]])
    orders, share = mode_orders(mixed, SIZE)
    assert orders.tolist() == [[1, 1], [2, 1]]
    np.testing.assert_allclose(share, [0.8, 1.0], rtol=1e-10)


@pytest.mark.parametrize("size", [100, 0.01])
@pytest.mark.parametrize("sign", [1, -1])
def test_the_size_of_a_shape_does_not_decide_its_order(size, sign):
    # in one subspace, the first 10° off (1, 1), the second 40° off it and of another size:
    # cos² 10° + sin² 40° > sin² 10° + cos² 40°, so (1, 1) is the first's
    ten, forty = np.radians(10), np.radians(40)
    change = [[sign * np.cos(ten), size * np.cos(forty)],
              [sign * np.sin(ten), size * np.sin(forty)]]  # fmt: skip
    orders, share = mode_orders(made_of_sines(SIZE, [(1, 1), (2, 1)], [100, 100], change), SIZE)
    assert orders.tolist() == [[1, 1], [2, 1]]
    np.testing.assert_allclose(share, 1.0, rtol=1e-10)
