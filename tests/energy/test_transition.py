"""Where the modal answer goes over into statistical energy, and where it does not."""

import numpy as np
import pytest

from pidpanel.energy.transition import Bands, factors_of, heavy, objection
from tests.energy.rectangles import SPEED, modal_forces, modes_in_band


def bands(**changes):
    """Six third octaves in which both answers agree, two of energy alone."""
    agreeing = {
        "centre": 1000 * 10 ** (np.arange(8) / 10),
        "modes": np.linspace(6, 20, 8),
        "difference_db": np.array([3.0, -2, 1.5, 0.9, -0.9, 0.1, np.nan, np.nan]),
        "at_coincidence": np.zeros(8, bool),
        "is_known": np.ones(8, bool),
        "mean_error": np.full(8, 0.1),
        "point_error": np.full(8, 0.3),
    }
    for name, (band, value) in changes.items():
        agreeing[name][band] = value
    return Bands(**agreeing)


def test_only_the_last_octave_of_the_modal_answer_decides():
    assert objection(bands()) == ""
    assert objection(bands(at_coincidence=(2, True), modes=(0, 1.0))) == ""


@pytest.mark.parametrize(
    ("change", "word"),
    [
        ({"modes": (3, 4.9)}, "4.9 modes"),
        ({"at_coincidence": (4, True)}, "coincidence"),
        ({"difference_db": (4, -1.1)}, "-1.1 dB"),
        ({"is_known": (5, False)}, "free edges"),
        ({"difference_db": (slice(None, 4), np.nan)}, "less than an octave"),
    ],
)
def test_each_condition_of_the_octave_is_named(change, word):
    assert word in objection(bands(**change))


def test_a_damper_of_more_than_half_the_panel_or_much_resistance_is_heavy():
    f = np.array([1000.0, 2000.0])
    light = 0.19 * 4.0 * 2 * np.pi * f
    assert heavy(f, light, np.full(2, 1.9), 4.0) == ""
    assert "m_a/m″ = 0.53 at 2000 Hz" in heavy(f, light, np.array([1.9, 2.1]), 4.0)
    assert "C_e/(m″ω) = 0.25 at 1000 Hz" in heavy(f, np.array([0.25, 0.19]) / 0.19 * light,
                                                  np.zeros(2), 4.0)  # fmt: skip


def test_modes_above_coincidence_receive_alike_and_show_sines():
    # product of two sines: ⟨sin⁴⟩/⟨sin²⟩² = 3/2 each
    size = (1.5, 1.0)

    def natural(pairs):
        return 44.9332 * np.sum((pairs / size) ** 2, axis=1)

    pairs = modes_in_band(size, natural, 1995.262, 21.0)
    x, y = np.meshgrid(np.arange(0.005, 1, 0.01), np.arange(0.005, 1, 0.01))
    places = np.stack([x.ravel(), y.ravel()], axis=1)
    shape = np.prod(np.sin(np.pi * places[:, None] * pairs), axis=2)
    force = modal_forces(size, pairs, 2 * np.pi * 1995.262 / SPEED)
    overlap = np.full(len(pairs), 1.5 / 4)
    factors = factors_of(force, overlap, shape, np.full(len(places), 1.5e-4))
    assert 1.0 <= factors.force < 1.1
    assert factors.shape == pytest.approx(2.25, rel=1e-6)
