"""A tone's frequency and acceleration say everything else about it."""

import math

import numpy as np
import pytest

from pidpanel.coupon.drive import Tone


def test_speed_and_amplitude_are_those_of_the_motion_whose_acceleration_it_is():
    tone = Tone(frequency=80.0, acceleration=50.0)
    assert tone.angular_frequency == pytest.approx(2 * math.pi * 80.0)
    assert tone.period * tone.frequency == 1
    t = np.linspace(0, tone.period, 20001)
    w = tone.amplitude * np.sin(tone.angular_frequency * t)
    velocity = np.gradient(w, t)
    # central differences of 20000 steps a period are good to (2π/20000)²/6; the ends are not
    assert velocity[1:-1].max() == pytest.approx(tone.speed, rel=1e-6)
    inner = np.gradient(velocity, t)[2:-2]
    driven = tone.acceleration_at(tone.angular_frequency * t)
    assert driven.max() == pytest.approx(50.0)
    # what is seen from the cells is driven against their own acceleration
    np.testing.assert_allclose(driven[2:-2], -inner, atol=1e-4 * tone.acceleration)
