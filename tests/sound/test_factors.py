"""G in few columns."""

import numpy as np
import pytest

from pidpanel.sound.wavenumber_table import (
    FACTOR_TOLERANCES,
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
    of = table(odd)
    widths = []
    for k in (1.0, 5.0, 12.0):
        lines = k * np.linspace(1.0, 1.04, 5)
        L, G = of.factors_at(lines), of.matrix(lines)
        widths.append(L.shape[2])
        diagonal = np.sqrt(np.einsum("fii->fi", G).real)
        left = np.abs(G - L @ L.conj().swapaxes(1, 2))
        assert np.all(
            left <= SLACK * FACTOR_TOLERANCES[0] * diagonal[:, :, None] * diagonal[:, None]
        )
    assert widths == sorted(widths)
    assert widths[0] < SHAPES / 5  # long waves push in few ways


def test_bands_follow_one_another_in_any_order():
    of = table()
    first = of.factors_at([2.0])
    of.factors_at([15.0])
    np.testing.assert_array_equal(of.factors_at([2.0]), first)


def test_a_matrix_that_is_not_positive_has_no_factors():
    assert table(noise=1e-6).factors_at([2.0]) is None


def test_nothing_is_extrapolated():
    with pytest.raises(FieldError, match="the table reaches to 20"):
        table().factors_at([21.0])


def test_shapes_of_any_size_are_factored_to_their_own_size():
    of = table()
    size = np.resize([1.0, 1e-3, 30.0, 0.0], SHAPES)  # every fourth is not pushed at all
    scaled = WavenumberTable(K_MAX, of.wavenumber, of.even * size[:, None] * size)
    (L,), (G,) = scaled.factors_at([3.0]), scaled.matrix([3.0])
    own = np.sqrt(np.maximum(np.diag(G), 1e-10 * np.diag(G).max()))
    assert np.all(np.abs(G - L @ L.T) <= SLACK * FACTOR_TOLERANCES[0] * own[:, None] * own)
    assert np.all(L[size == 0] == 0)
    assert L.shape[1] <= of.factors_at([3.0]).shape[2]


def test_a_field_without_force_has_no_factors():
    nodes = chebyshev_nodes(K_MAX, 4)
    assert WavenumberTable(K_MAX, nodes, np.zeros((4, 3, 3))).factors_at([3.0]) is None
    assert table().factors_at([0.0]) is None
    assert table().factors_at([]) is None
    assert table().factors_at([0.5]) is not None
