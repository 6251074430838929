"""A drawn record has the cross-PSDs of the field, and keeps them from sample to step."""

import numpy as np
import pytest

from pidpanel.coupled.force_record import before_hold, draw_modal_force, force_nodes, samples
from pidpanel.solve.excitation import ModalForce


def field(complex_valued):
    """G of three shapes, of rank two, that turns with frequency."""

    def modal_force(frequency):
        f = frequency[:, None, None] / 100
        one = np.array([1.0, 0.5, 0.0]) + f * np.array([0.0, 0.3, 1.0])
        other = np.array([0.0, 1.0, 1e-3]) * (1j if complex_valued else 1.0) + 0 * f
        return sum(
            np.swapaxes(v, 1, 2) @ v.conj() for v in (one + 0j * complex_valued, other + one)
        )

    return modal_force


@pytest.mark.parametrize("complex_valued", [False, True])
def test_drawn_forces_have_the_cross_psds_of_the_field(complex_valued):
    # 40000 tones in a narrow band, over which G is one: a cross-PSD is known to 1/200 of
    # √(G_ii G_jj), four errors allowed
    modal_force = field(complex_valued)
    frequency = np.linspace(149.9, 150.1, 40001)
    nodes = np.array([140.0, 160.0])
    excitation = ModalForce(lambda f: np.full(f.shape, 3.0), modal_force)
    drawn = draw_modal_force(frequency, excitation, nodes, np.random.default_rng(1))
    step = frequency[1] - frequency[0]
    found = drawn.T @ drawn.conj() / (2 * step * len(frequency))
    ends = modal_force(nodes)
    wanted = 3.0 * (ends[0] + ends[1]) / 2
    size = np.sqrt(np.diagonal(wanted).real)
    assert np.max(np.abs(found - wanted) / np.outer(size, size)) < 4 / 200


def squares(matrix, frequency, nodes, seed=1):
    """|X|² over 2 S Δf of tones of a field, (nf, n)."""
    excitation = ModalForce(lambda f: np.full(f.shape, 3.0), matrix)
    drawn = draw_modal_force(frequency, excitation, nodes, np.random.default_rng(seed))
    return np.abs(drawn) ** 2 / (6.0 * (frequency[1] - frequency[0])), drawn


def test_a_tone_has_the_size_of_the_field_at_its_frequency():
    # √G of one shape is linear between nodes, at them exact and held beyond; sizes are not drawn
    def matrix(frequency):
        return (1.0 + (frequency / 100.0) ** 3)[:, None, None]

    nodes = np.array([100.0, 130.0, 200.0, 210.0])
    frequency = np.arange(90.0, 226.0, 5.0)
    found, _ = squares(matrix, frequency, nodes)
    root = np.interp(frequency, nodes, np.sqrt(matrix(nodes)[:, 0, 0]))
    assert found[:, 0] == pytest.approx(root**2, rel=2e-6)


def test_phases_have_no_preference():
    # 4000 of them, whose mean is known to 1/√4000
    frequency = np.linspace(100.0, 200.0, 4000)
    _, drawn = squares(np.eye(1), frequency, np.array([100.0, 200.0]))
    turned = drawn[:, 0] / np.abs(drawn[:, 0])
    for power in (1, 2, 3):
        assert abs(np.mean(turned**power)) < 4 / np.sqrt(4000)


class Columns(ModalForce):
    """A field that knows its factors, which grow with frequency."""

    def factors(self, frequency):
        return (frequency / 100)[:, None, None] * self.matrix


@pytest.mark.parametrize("columns", [1, 2])
def test_a_field_with_few_columns_is_drawn_from_them(columns):
    # 40000 tones: a correlation is known to 1/200, and a phase at random has no mean
    root = np.array([[2.0, 1.0 + 1j], [0.5, 1j], [0.0, 3.0]])[:, :columns]
    frequency = np.linspace(149.9, 150.1, 40001)
    excitation = Columns(lambda f: np.full(f.shape, 3.0), root)
    drawn = draw_modal_force(frequency, excitation, np.ones(0), np.random.default_rng(1))
    drawn = drawn / np.sqrt(6.0 * (frequency[1] - frequency[0])) / 1.5
    wanted = root @ root.conj().T
    found = drawn.T @ drawn.conj() / len(frequency)
    assert np.abs(found - wanted).max() < 4 / 200 * np.abs(wanted).max()
    if columns == 1:
        assert found == pytest.approx(wanted, rel=1e-5, abs=1e-9)
    assert np.abs(drawn.mean(axis=0)).max() < 4 / 200 * 3


def test_what_is_below_zero_in_a_table_counts_as_none():
    # correlation 1.01 of two shapes: what is left is that along (1, 1), of half of 2.01 each
    size = np.array([2.0, 0.5])
    matrix = np.outer(size, size) * np.array([[1.0, 1.01], [1.01, 1.0]])
    found, drawn = squares(matrix, np.linspace(100.0, 110.0, 11), np.array([90.0, 120.0]))
    assert found == pytest.approx(np.broadcast_to(1.005 * size**2, (11, 2)), rel=1e-9)
    assert drawn[:, 0] / drawn[:, 1] == pytest.approx(np.full(11, 4.0 + 0j), rel=1e-9)


def test_nodes_are_close_where_waves_are_long_and_end_where_they_should():
    nodes = force_nodes(30.0, 2000.0, 343.0, 1.8)
    assert (nodes[0], nodes[-1]) == (30.0, 2000.0)
    assert np.all(np.diff(nodes) > 0)
    # and no closer than needed
    assert np.max(np.diff(nodes)) == pytest.approx(0.2 * 343 / (2 * np.pi * 1.8), rel=1e-12)
    assert np.max(np.diff(nodes) / nodes[:-1]) == pytest.approx(0.05, rel=1e-12)


def test_samples_are_the_sum_of_the_tones():
    amplitude = np.array([[1.0 + 2j], [0.5 - 1j]])
    time = np.arange(64) / 64
    wanted = sum(
        (x * np.exp(2j * np.pi * (3 + j) * time)).real for j, x in enumerate(amplitude[:, 0])
    )
    assert samples(amplitude, 3, 64)[:, 0] == pytest.approx(wanted, abs=1e-12)


def test_a_tone_joined_linearly_keeps_its_size():
    # ten samples a period, joined by 50 steps each: its first harmonic is that of the tone
    time = np.arange(10) / 10
    rows = np.cos(2 * np.pi * time) * before_hold(np.array([1.0]), 0.1)[0]
    fine = np.arange(500) / 500
    joined = np.interp(fine, [*time, 1.0], [*rows, rows[0]])
    assert 2 * np.mean(joined * np.cos(2 * np.pi * fine)) == pytest.approx(1.0, rel=1e-3)
