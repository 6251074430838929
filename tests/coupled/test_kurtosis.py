"""Excess kurtosis from records: of Gaussian motions, of bursts, with the scatter of both."""

import numpy as np

from pidpanel.coupled.kurtosis import bursts_of
from pidpanel.coupled.segments import SettledRecord

INTERVAL, SETTLED, ROWS = 1 / 5000, 500, 12500
TONES = np.arange(60, 1000) / 2.4  # [Hz]


def record(acceleration):
    """A record whose displacement at a point has the acceleration of some tones."""
    time = np.arange(len(acceleration)) * INTERVAL
    spectrum = np.fft.rfft(acceleration)
    frequency = np.fft.rfftfreq(len(acceleration), INTERVAL)
    inside = (frequency > 30) & (frequency < 380)
    omega = np.where(inside, 2 * np.pi * frequency, 1.0)
    displacement = np.fft.irfft(np.where(inside, -spectrum / omega**2, 0), len(acceleration))
    points = np.stack([displacement + 1e-4 * time, 3 * displacement], axis=1)
    none = np.zeros((len(time), 1))
    return SettledRecord(
        TONES, np.zeros((TONES.size, 1), complex), 60, ROWS, SETTLED, INTERVAL, none, points, none
    )


def test_gaussian_records_have_none_within_their_scatter():
    rng = np.random.default_rng(1)
    z, excess = [], []
    for _ in range(12):
        value, error, damage, _ = bursts_of([record(rng.normal(size=ROWS + 1)) for _ in range(2)])
        excess.append(damage[:2, 0])
        assert value[0] == np.clip(value[0], value[1] - 1e-3, value[1] + 1e-3)  # drift and scale
        z.append(value[0] / error[0])
    assert 0.6 < np.std(z) < 1.6
    assert abs(np.mean(z)) < 0.6
    assert np.abs(np.mean(excess, axis=0)).max() < 0.05


def test_bursts_have_the_kurtosis_of_their_intensity():
    # a Gaussian motion with a slow factor a has 3 ⟨a⁴⟩/⟨a²⟩² of it; 1 and 2 in turn: 2.04
    rng = np.random.default_rng(2)
    slow = 1.0 + (np.arange(ROWS + 1) // 1250 % 2)
    bursts = bursts_of([record(slow * rng.normal(size=ROWS + 1)) for _ in range(8)])
    value, error, *_ = bursts
    expected = 3 * 8.5 / 2.5**2 - 3
    assert abs(value[0] - expected) < 3 * error[0]
    assert error[0] < 0.4
    # of b = 8: ⟨a⁸⟩/⟨a²⟩⁴
    for row, b in ((0, 4), (1, 8)):
        wanted = np.log((1 + 2**b) / 2 / 2.5 ** (b / 2))
        assert abs(bursts.damage[row, 0] - wanted) < 3 * bursts.damage_error[row, 0] < 0.6
