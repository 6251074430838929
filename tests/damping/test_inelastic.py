"""Closed forms of the perfectly inelastic body against tables and against stepped flight."""

import math
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping import inelastic

REFERENCE = Path(__file__).parent


def table(name):
    return pd.read_csv(REFERENCE / f"{name}.csv", comment="#").to_numpy()


def test_the_slug_between_walls_is_that_of_the_table():
    # the table has six decimals
    for gap, energy, *_ in table("collect_and_collide_e0"):
        assert inelastic.slug_energy(gap) == pytest.approx(energy, abs=1e-6)


def test_the_body_on_a_floor_is_that_of_the_table():
    # the table's last Γ is rounded up past the end of the range
    for gamma, _, _, energy, *_ in table("bouncing_bed_e0"):
        gamma = min(gamma, inelastic.LARGEST_GAMMA)
        assert inelastic.floor_energy(gamma) == pytest.approx(energy, abs=1e-6)


def test_the_body_loses_nothing_until_the_floor_falls_away_from_it():
    assert inelastic.floor_energy(1.0) == 0.0
    # u ∝ (Γ² − 1)^{3/2} at first, so that next to nothing is lost just above
    assert 0 < inelastic.floor_energy(1.01) < 1e-4


def test_the_largest_losses_are_where_they_are_said_to_be():
    gaps = np.linspace(0.01, inelastic.LONGEST_GAP, 2001)
    energy = [inelastic.slug_energy(gap) for gap in gaps]
    assert max(energy) <= 4 and gaps[np.argmax(energy)] == pytest.approx(math.pi, abs=0.01)
    gammas = np.linspace(1.0, inelastic.LARGEST_GAMMA, 2001)
    energy = [inelastic.floor_energy(gamma) for gamma in gammas]
    assert max(energy) == pytest.approx(2.2604, abs=1e-4)
    assert gammas[np.argmax(energy)] == pytest.approx(2.581, abs=0.005)


@pytest.mark.parametrize(
    ("form", "value", "text"),
    [
        (inelastic.slug_energy, 0.0, "L/A = 0: above 0, up to 3.724"),
        (inelastic.slug_energy, 3.8, "L/A = 3.8: above 0, up to 3.724"),
        (inelastic.floor_energy, 3.3, "Γ = 3.3: above 0, up to 3.297"),
    ],
)
def test_outside_its_range_a_form_is_refused(form, value, text):
    with pytest.raises(ValueError, match=text):
        form(value)


@pytest.mark.parametrize("gamma", [1.1, 1.7, 3.0])
@pytest.mark.parametrize("restitution", [0.3, 0.5, 0.9])
def test_a_ball_that_lands_once_a_period_loses_what_its_impact_takes(gamma, restitution):
    amplitude, omega, gravity = 2.0, 3.0, 2.0 * 3.0**2 / gamma
    take_off = gravity * (2 * np.pi / omega) / 2
    floor = take_off * (1 - restitution) / (1 + restitution)
    assert restitution * (take_off + floor) == pytest.approx(take_off - floor)
    lost = ((take_off + floor) ** 2 - (take_off - floor) ** 2) / 2
    expected = lost / (amplitude * omega) ** 2
    assert inelastic.ball_energy(gamma, restitution) == pytest.approx(expected, rel=1e-12)


@pytest.mark.parametrize("gap", [0.01, 0.4, 1.3, 2.9, 3.3, 3.7])
def test_the_slug_returns_the_first_harmonic_of_its_flight(gap):
    # its momentum over a cycle, stepped: in phase with the wall's velocity cos θ it is m_a, in
    # quadrature E/π (docs/theory/index.md, dissipated energy)
    theta = (np.arange(200_000) + 0.5) * 2 * np.pi / 200_000
    if gap <= np.pi:
        leaves, lands = 0.0, float(inelastic._landing(np.array(gap)))
    else:
        leaves = math.atan(2 / math.pi) - math.acos(gap / inelastic.LONGEST_GAP)
        lands = np.pi + leaves
    since = np.mod(theta - leaves, np.pi)  # of the half cycle, which repeats with the other sign
    sign = np.where(np.mod(theta - leaves, 2 * np.pi) < np.pi, 1, -1)
    wall = np.cos(since + leaves)
    velocity = sign * np.where(since < lands - leaves, np.cos(leaves), wall)
    energy, mass = inelastic.slug(gap)
    # the midpoint rule misses the landing by half a step, 1.6e-5
    assert 2 * np.mean(velocity * np.cos(theta)) == pytest.approx(float(mass), abs=1e-4)
    assert 2 * np.mean(velocity * np.sin(theta)) == pytest.approx(float(energy) / np.pi, abs=1e-4)
