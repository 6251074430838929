"""G in few columns."""

import numpy as np
import pytest

from pidpanel.sound.wavenumber_table import (
    FACTOR_TOLERANCE,
    SLACK,
    FieldError,
    WavenumberTable,
    chebyshev_nodes,
)

K_MAX, SHAPES = 20.0, 60


def table(odd=False, noise=0.0):
    """Waves of at most k on a line of 1 m, which push 60 sines: few of them where k is small."""
    nodes = chebyshev_nodes(K_MAX, 40)
    x = np.linspace(0.0, 1.0, 400)
    shapes = np.sin(np.pi * np.arange(1, SHAPES + 1)[:, None] * x) / x.size
    angle, weight = np.polynomial.legendre.leggauss(60)

    def at(k, wave):
        return (weight * wave) @ wave.conj().T

    even, over_k = [], []
    for k in nodes:
        forces = shapes @ np.exp(1j * k * np.outer(x, angle + (1.0 if odd else 0.0)))
        G = at(k, forces)
        even.append(G.real)
        over_k.append(G.imag / k)
    even = np.array(even) + noise * np.diag(np.resize([1.0, -1.0], SHAPES))
    return WavenumberTable(K_MAX, nodes, even, np.array(over_k) if odd else None)


@pytest.mark.parametrize("odd", [False, True])
def test_the_factors_are_g_to_their_tolerance(odd):
    # red: in factors_at, self._pivots[band] = ...[:-2]; or in _factors, turned.T
    of = table(odd)
    widths = []
    for k in (1.0, 5.0, 12.0):
        lines = k * np.linspace(1.0, 1.04, 5)
        L, G = of.factors_at(lines), of.at(lines)
        widths.append(L.shape[2])
        diagonal = np.sqrt(np.einsum("fii->fi", G).real)
        left = np.abs(G - L @ L.conj().swapaxes(1, 2))
        assert np.all(left <= SLACK * FACTOR_TOLERANCE * diagonal[:, :, None] * diagonal[:, None])
    assert widths == sorted(widths)
    assert widths[0] < SHAPES / 5  # long waves push in few ways


def test_bands_follow_one_another_in_any_order():
    # red: in factors_at, if not self._rows
    of = table()
    first = of.factors_at([2.0])
    of.factors_at([15.0])
    np.testing.assert_array_equal(of.factors_at([2.0]), first)


def test_forces_that_need_all_shapes_have_no_factors():
    # red: FACTOR_SHARE = 2.0
    nodes = chebyshev_nodes(K_MAX, 4)
    whole = WavenumberTable(K_MAX, nodes, np.broadcast_to(np.eye(8), (4, 8, 8)))
    assert whole.factors_at([3.0]) is None


def test_a_matrix_that_is_not_positive_has_no_factors():
    # red: in _factors, left the comparison with SLACK out
    assert table(noise=1e-6).factors_at([2.0]) is None


def test_nothing_is_extrapolated():
    # red: k = checked_wavenumber(wavenumber) in factors_at
    with pytest.raises(FieldError, match="the table reaches to 20"):
        table().factors_at([21.0])


@pytest.mark.parametrize("odd", [False, True])
def test_long_waves_are_read_from_a_shorter_table_of_the_same_values(odd):
    # red: in _up_to, k_max = self.wavenumber_max / NARROWER ** (band + 1); or SPARE_NODES = 6
    of = table(odd)
    for k in (0.0, 0.05, 1.0, 5.0, 9.0, 16.5, 20.0):
        assert of._up_to(k).wavenumber.size <= (30 if k < 10 else 40)
        whole, read = of._at(np.array([k])), of.at([k])
        assert np.max(np.abs(read - whole)) <= 1e-11 * np.max(np.abs(whole))


def test_shorter_tables_follow_one_another_in_any_order():
    # red: in _up_to, if not self._shorter
    of = table()
    first = of.at([2.0])
    of.at([9.0])
    np.testing.assert_array_equal(of.at([2.0]), first)
