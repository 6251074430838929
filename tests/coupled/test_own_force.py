"""PSD, coherence and coherence length of the own force come back from drawn ones."""

import numpy as np
import pytest

from pidpanel.coupled.own_force import USUAL_LENGTH, fitted_own_force, own_force_sums

CENTRE = np.array([100.0, 200.0, 400.0])
EDGE = np.stack([CENTRE * 0.89, CENTRE * 1.12], axis=1)
PER_BAND, SEGMENTS = 100, 30
PLACE = np.array([(x, y) for x in np.arange(4) * 0.05 for y in np.arange(4) * 0.05])


def apart(place):
    return np.hypot(*(place[:, None] - place[None]).transpose(2, 0, 1))


def drawn(seed, place, coherence, length, psd=(1.0, 1.0, 1.0)):
    """Frequency and n (segments, lines, cells) with γ = c exp(−d f/λ), f that of its band."""
    rng = np.random.default_rng(seed)
    frequency = np.concatenate([np.linspace(*edge, PER_BAND, endpoint=False) for edge in EDGE])
    parts = []
    for f, c, s in zip(CENTRE, coherence, psd, strict=True):
        matrix = c * np.exp(-apart(place) * f / length) + (1 - c) * np.eye(len(place))
        root = np.sqrt(s) * np.linalg.cholesky(matrix + 1e-9 * np.eye(len(place)))
        size = (SEGMENTS, PER_BAND, len(place))
        white = rng.standard_normal(size) + 1j * rng.standard_normal(size)
        parts.append(white / np.sqrt(2) @ root.T)
    return frequency, np.concatenate(parts, axis=1)


def fitted(frequency, own, place):
    sums = own_force_sums(frequency, own, EDGE).sum(axis=0)
    lines = np.full(len(CENTRE), PER_BAND * SEGMENTS)
    return fitted_own_force(sums, lines, CENTRE, apart(place))


@pytest.mark.parametrize("length", [15.0, 30.0, 80.0])
def test_coherence_length_and_psd_come_back(length):
    # of 3000 lines a correlation scatters by 1/√6000 = 1.3 %, that of 120 pairs less; PSDs of 16
    # cells by 1/√3000 to that over √16; steps of λ are 8 %
    coherence, psd = np.array([0.9, 0.6, 0.3]), np.array([2.0, 5.0, 0.5])
    found = fitted(*drawn(1, PLACE, coherence, length, psd), PLACE)
    assert found.length == pytest.approx(length, rel=0.15)
    assert found.coherence == pytest.approx(coherence, abs=0.05)
    assert found.psd == pytest.approx(psd, rel=0.05)


def test_impacts_that_have_nothing_to_do_with_each_other_have_no_coherence():
    for seed in range(2, 8):
        found = fitted(*drawn(seed, PLACE, np.zeros(3), 30.0), PLACE)
        assert np.all(found.coherence >= 0)
        assert found.coherence == pytest.approx(np.zeros(3), abs=0.02)


def test_of_cells_at_one_place_the_length_is_the_usual_one():
    place = np.zeros((4, 2))
    found = fitted(*drawn(3, place, np.array([0.9, 0.6, 0.3]), 100.0), place)
    assert found.coherence == pytest.approx([0.9, 0.6, 0.3], abs=0.05)
    assert found.length == pytest.approx(30.0, rel=0.03)  # of acrylic, from 18 to 50


def test_a_single_cell_has_a_psd_and_no_coherence():
    found = fitted(*drawn(4, PLACE[:1], np.zeros(3), 30.0, (2.0, 5.0, 0.5)), PLACE[:1])
    assert found.psd == pytest.approx([2.0, 5.0, 0.5], rel=0.1)
    assert found.coherence.tolist() == [0.0, 0.0, 0.0]
    assert found.length == USUAL_LENGTH == 30.0


def test_two_cells_that_feel_one_force_have_the_coherence_one():
    # of a single line, with λ at about the usual one, at which two cells would have less
    found = fitted_own_force(np.ones((3, 2, 2)), np.ones(3), CENTRE, 0.1 * (1 - np.eye(2)))
    assert 30 < found.length < 80
    assert found.coherence.tolist() == [1.0, 1.0, 1.0]
