"""The solver's contacts, and the product's shake deck, against closed forms (real LIGGGHTS)."""

import numpy as np
import pytest

from pidpanel.damping import inelastic
from pidpanel.verification.coupon import CASES, contacts, shaken
from pidpanel.verification.rows import COMPARISONS

pytestmark = pytest.mark.liggghts

TOLERANCE = {name: values["tolerance"] for name, values in COMPARISONS.items()}


@pytest.mark.parametrize("restitution", [0.3, 0.6, 0.8, 0.95])
def test_a_collision_loses_what_its_restitution_says(tmp_path, restitution):
    # first order in the step, 1.0 % at a tenth of the Rayleigh time
    lost = contacts.energy_lost(tmp_path, restitution, 0.1)
    assert lost == pytest.approx(1 - restitution**2, rel=TOLERANCE["collision"])


def test_the_error_of_a_collision_falls_in_proportion_to_the_step(tmp_path):
    truth = 1 - 0.8**2
    coarse, fine = (
        np.abs(contacts.energy_lost(tmp_path / f"{step}", 0.8, step) - truth).max()
        for step in (0.2, 0.025)
    )
    # the worst of eight moments of meeting: an eighth of the step leaves an eighth of the
    # error at first order, give or take the half that eight moments leave open
    assert 1 / 16 < fine / coarse < 1 / 4
    assert fine < 0.01 * truth


def test_a_collision_without_loss_loses_nothing(tmp_path):
    lost = contacts.energy_lost(tmp_path, 1.0, 0.1)
    assert np.abs(lost).max() < TOLERANCE["lossless"]


def test_a_sliding_sphere_ends_rolling_at_five_sevenths_of_its_speed(tmp_path):
    # no time constant is in the answer, only momentum
    # leaves it sliding
    speed = contacts.rolling_speed(tmp_path, 0.2) / 0.2
    assert speed == pytest.approx(5 / 7, rel=TOLERANCE["sliding"])


@pytest.mark.parametrize("case", ["rolling", "oblique", "peak", "growth"])
def test_single_contacts_are_those_of_their_closed_forms(tmp_path, case):
    assert all(row.met for row in CASES[case](tmp_path))


def test_a_ball_that_lands_once_a_period_loses_what_the_closed_form_says(tmp_path):
    _, energy = shaken.ball(tmp_path, restitution=0.5, gamma=1.25)
    truth = inelastic.ball_energy(1.25, 0.5)
    assert energy == pytest.approx(truth, rel=TOLERANCE["ball"])


@pytest.fixture(scope="module")
def settled(tmp_path_factory):
    """Centres of a poured bed."""
    return shaken.poured(tmp_path_factory.mktemp("pour"))


def test_many_inelastic_spheres_in_a_box_lose_what_a_perfectly_inelastic_slug_does(
    tmp_path, settled
):
    truth = inelastic.slug_energy(2.0)
    _, many = shaken.slug(tmp_path / "many", settled, 48, 2.0, count=4)
    _, one = shaken.slug(tmp_path / "one", settled, 1, 2.0, count=4)
    # a lone sphere keeps e = 0.3 of its speed and is 16 % off; four layers of them are not;
    assert many == pytest.approx(truth, rel=TOLERANCE["slug"])
    assert abs(one - truth) > 0.1 * truth


def test_many_inelastic_spheres_on_a_floor_lose_what_a_perfectly_inelastic_bed_does(
    tmp_path, settled
):
    truth = inelastic.floor_energy(2.0)
    _, many = shaken.floor_bed(tmp_path / "many", settled, 48, 2.0, count=6)
    _, one = shaken.floor_bed(tmp_path / "one", settled, 1, 2.0, count=6)
    # a lone sphere is 14 % off
    assert many == pytest.approx(truth, rel=TOLERANCE["floor"])
    assert abs(one - truth) > 0.1 * truth


def test_below_one_g_a_bed_on_a_floor_loses_nothing(tmp_path, settled):
    _, energy = shaken.floor_bed(tmp_path, settled, 12, 0.9, count=5)
    # 0 in truth; half a per cent of the largest loss
    assert abs(energy) < TOLERANCE["onset"]
