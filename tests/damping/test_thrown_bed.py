"""The inelastic body under a random motion, from which the rounds of the random drive start."""

from dataclasses import replace

import numpy as np
import pytest

from pidpanel.damping.thrown_bed import FARTHEST, ThrownBed
from pidpanel.inelastic import at_impacts, impact_rate

EDGES = np.array([50.0, 100.0, 200.0, 400.0])
BED = ThrownBed(mass=5.0, gap=0.013, gravity=9.80665)


def simulated(gravity, gap, velocity, time, step=2e-5):
    """C_e/m [1/s] of a point that takes the velocity of a wall, at random, when it meets it."""
    rng, count = np.random.default_rng(3), round(time / step)
    line = np.fft.rfftfreq(count, step)
    spectrum = np.where(
        (line >= 100) & (line <= 400), np.exp(2j * np.pi * rng.random(line.size)), 0
    )
    spectrum *= velocity / np.fft.irfft(spectrum, count).std()
    place = np.divide(spectrum, 2j * np.pi * line, out=np.zeros_like(spectrum), where=line > 0)
    walls = zip(*(np.fft.irfft(one, count).tolist() for one in (spectrum, place)), strict=True)
    speed, height = next(walls)
    work = 0.0
    for wall, floor in walls:
        speed -= gravity * step
        height += speed * step
        below, above = height < floor, height > floor + gap
        if below or above:
            if (wall > speed) if below else (wall < speed):
                work += (wall - speed) * wall
                speed = wall
            height = floor if below else floor + gap
    return work / time / velocity**2


@pytest.mark.parametrize(
    ("gravity", "gap", "velocity"), [(9.80665, 1.0, 0.1), (0.0, 0.01, 0.5), (9.80665, 0.01, 4.0)]
)
def test_the_rate_is_about_that_of_a_body_that_is_simulated(gravity, gap, velocity):
    """It clings to a wall for a while, which beds of spheres do not; theirs is above."""
    # red: `* gravity / v` → `* gravity * v`; `* v / gap` → `/ (v * gap)` in impact_rate
    rate = float(impact_rate(velocity, gap, gravity))
    assert 1.2 < rate / simulated(gravity, gap, velocity, 1.5) < 2.7


def test_a_body_that_meets_a_wall_at_random_instants_is_a_mass_behind_a_dashpot():
    # red: `(omega / …) ** 2` → `(omega / …)` in at_impacts
    rate, frequency, count = 300.0, np.array([20.0, 60.0, 200.0]), 400_000
    between = np.random.default_rng(1).exponential(1 / rate, count)
    instant = np.cumsum(between)
    damping, mass = at_impacts(frequency, rate)
    for f, c, m in zip(frequency, damping, mass, strict=True):
        turn = np.exp(2j * np.pi * f * instant)  # of a wall of unit speed
        force = np.diff(turn.real, prepend=0.0)
        seen = 2 * np.sum(force * turn.conj()) / instant[-1]
        assert seen.real == pytest.approx(c, rel=0.03, abs=3)
        assert seen.imag / (2 * np.pi * f) == pytest.approx(m, abs=0.03)


def test_a_bed_rides_at_rest_and_is_free_where_it_is_thrown():
    # red: `self.mass * mass` → `mass` in values; LEAST_VELOCITY = 1
    damping, mass = BED.values(np.array([100.0]), 1e-9)
    assert mass == pytest.approx(5.0) and damping < 1.0
    damping, mass = BED.values(np.array([100.0]), 0.4)
    assert damping == pytest.approx(5 * 1.596 * 9.80665 / 0.4, rel=0.1) and mass < 0.1
    none = ThrownBed(5.0, 0.013, 0.0).values(np.array([100.0]), 0.0)
    assert np.isfinite(none).all()


def test_its_reading_is_that_of_its_bands():
    # red: `edges[:-1]` → `edges[1:]` in the frequency of reading
    reading = BED.reading(EDGES, 0.2)
    damping, mass = BED.values(reading.nodes, 0.2)
    values = reading(reading.nodes, 0.5, 1.0)
    assert values.equivalent_damping == pytest.approx(damping)
    assert values.apparent_mass == pytest.approx(mass)
    assert reading.nodes == pytest.approx([70.7, 141.4, 282.8], rel=1e-3)
    assert (values.equivalent_damping_error == 0).all() and reading.mass_per_area(0.5) == 5.0


def with_damping(reading, factor, error=0.02):
    damping = reading.bands.equivalent_damping * factor
    return replace(
        reading,
        bands=replace(
            reading.bands, equivalent_damping=damping, equivalent_damping_error=error * damping
        ),
    )


def test_what_was_found_is_carried_as_the_body_changes():
    # red: `** exponent` left out; `+ is_[1] - was[1]` left out
    found = with_damping(BED.reading(EDGES, 0.02), 2.0)
    carried = BED.carried(found, 0.02, 0.0, 0.025).bands
    there = BED.reading(EDGES, 0.025).bands
    assert carried.equivalent_damping == pytest.approx(2 * there.equivalent_damping)
    assert carried.equivalent_damping_error == pytest.approx(0.02 * carried.equivalent_damping)
    assert carried.apparent_mass == pytest.approx(there.apparent_mass)
    further = BED.carried(found, 0.02, 2.0, 0.025).bands
    assert further.equivalent_damping == pytest.approx(1.25**2 * carried.equivalent_damping)


@pytest.mark.parametrize("away", [2.0, 0.5])
def test_nothing_is_carried_far(away):
    # red: `velocity * FARTHEST` → `9`; `velocity / FARTHEST` → `0`
    found = BED.reading(EDGES, 0.02)
    carried = BED.carried(found, 0.02, 3.0, 0.02 * away).bands
    edge = 0.02 * FARTHEST ** np.sign(away - 1)
    near = BED.carried(found, 0.02, 3.0, edge).bands
    assert carried.equivalent_damping == pytest.approx(near.equivalent_damping)
    assert carried.equivalent_damping != pytest.approx(found.bands.equivalent_damping, rel=0.1)


def seen_with(exponent, velocities, error=0.02):
    """What would be found where C_e changes with a power besides."""
    return [
        (with_damping(BED.reading(EDGES, v), 3 * v**exponent, error=error), v) for v in velocities
    ]


@pytest.mark.parametrize(("exponent", "told"), [(0.0, 0.0), (1.0, 1.0), (-1.5, -1.5), (9.0, 4.0)])
def test_the_exponent_is_the_one_that_was_seen(exponent, told):
    # red: `(damping - body)` → `damping`; `- np.sum(share * log_velocity, axis=0)` left out
    found = seen_with(exponent, [0.1, 0.12, 0.15])
    assert BED.exponent_seen(found) == pytest.approx(told, abs=0.15)


def test_motions_that_are_the_same_or_far_away_tell_nothing():
    # red: `UNSURE**-2 +` left out; `<= NEAR` → `<= 9`
    other = with_damping(BED.reading(EDGES, 0.1005), np.array([3.6, 2.7, 3.3]), error=0.2)
    noisy = [*seen_with(0.0, [0.1]), (other, 0.1005)]
    assert BED.exponent_seen(noisy) == pytest.approx(0.0, abs=0.05)
    assert BED.exponent_seen(seen_with(1.0, [0.02, 0.1])) == 0.0
