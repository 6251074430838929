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
    # red: `before.T` twice in `draw_modal_force`; 2 left out of the amplitude
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


def test_nodes_are_close_where_waves_are_long_and_end_where_they_should():
    # red: min → max in `force_nodes`
    nodes = force_nodes(30.0, 2000.0, 343.0, 1.8)
    assert (nodes[0], nodes[-1]) == (30.0, 2000.0)
    assert np.all(np.diff(nodes) > 0)
    assert np.max(np.diff(nodes)) <= 0.2 * 343 / (2 * np.pi * 1.8) * (1 + 1e-12)
    assert np.max(np.diff(nodes) / nodes[:-1]) <= 0.05 * (1 + 1e-12)


def test_samples_are_the_sum_of_the_tones():
    # red: count / 2 → count in `samples`
    amplitude = np.array([[1.0 + 2j], [0.5 - 1j]])
    time = np.arange(64) / 64
    wanted = sum(
        (x * np.exp(2j * np.pi * (3 + j) * time)).real for j, x in enumerate(amplitude[:, 0])
    )
    assert samples(amplitude, 3, 64)[:, 0] == pytest.approx(wanted, abs=1e-12)


def test_a_tone_joined_linearly_keeps_its_size():
    # ten samples a period, joined by 50 steps each: its first harmonic is that of the tone
    # red: 1/sinc² → 1
    time = np.arange(10) / 10
    rows = np.cos(2 * np.pi * time) * before_hold(np.array([1.0]), 0.1)[0]
    fine = np.arange(500) / 500
    joined = np.interp(fine, [*time, 1.0], [*rows, rows[0]])
    assert 2 * np.mean(joined * np.cos(2 * np.pi * fine)) == pytest.approx(1.0, rel=1e-3)
