"""Viscoelastic impacts: closed forms, and the constants in the decks of coupons and panels."""

import math
import re
from dataclasses import replace

import pytest
from pydantic import ValidationError

from pidpanel.coupled.beds import StartedBed, deck_of
from pidpanel.coupon import contact
from pidpanel.coupon.from_study import bed_of, cases_of
from pidpanel.coupon.impacts import rebound, viscous_group
from pidpanel.study.coupon import Coupon
from pidpanel.study.coupon_study import VariedCoupon
from pidpanel.study.mistakes import mistakes_of
from pidpanel.study.requirements import mistakes_of_coupon
from tests.coupons import SMALL, with_changes

LAW = {"value": 0.8, "at_m_s": 0.5, "law": "viscoelastic"}


def coupon(restitution=LAW, **changes):
    particles = {"particles": {"restitution": restitution, "youngs_modulus_mpa": 3200}}
    return Coupon.model_validate(with_changes(with_changes(SMALL, particles), changes))


def test_weak_impacts_lose_in_proportion_to_their_group():
    # Schwager & Pöschel, Phys. Rev. E 57, 650 (1998): e = 1 − C₁ b + (3/5) C₁² b² − O(b³), with C₁
    # twice the work of √x x′ until the deepest point of Hertz's own impact, 1.1534
    first = 0.8 * 1.25**0.6 * math.gamma(0.6) * math.gamma(1.5) / math.gamma(2.1)
    for group in (0.01, 0.02):
        expected = 1 - first * group + 0.6 * first**2 * group**2
        assert rebound(group) == pytest.approx(expected, abs=group**3)


@pytest.mark.parametrize("restitution", [0.05, 0.3, 0.8, 1.0])
def test_the_group_of_a_restitution_gives_it_back(restitution):
    # the limit of 0.05 of a study is within the bracket of the root
    assert rebound(viscous_group(restitution)) == pytest.approx(restitution, abs=1e-7)


def rebounds(text, impacts):
    """e at the stated speed of two spheres and of a sphere at a wall, from the text of a deck."""
    mass = impacts.density * math.pi / 6 * (2 * impacts.radius) ** 3
    lines = re.findall(r"fix (kn|gamman) all .*&\n\s*(\S+) (\S+)", text)
    values = {name: tuple(map(float, pair)) for name, *pair in lines}
    for stiffness, damping, share in zip(values["kn"], values["gamman"], (0.5, 1.0), strict=True):
        # b = c/m* (m*/k)^{3/5} v^{1/5} with k and c/m* over √δ, R* and m* a half each of two spheres
        root = math.sqrt(share * impacts.radius)
        rate = share * mass / (stiffness * root)
        yield rebound(damping * root * rate**0.6 * impacts.speed**0.2)


@pytest.mark.parametrize("acceleration", [5, 20])
def test_a_coupon_has_its_restitution_at_its_speed_with_any_modulus(acceleration):
    walls = {"restitution": 0.7, "youngs_modulus_mpa": 64000}
    (case,) = cases_of(coupon(sweep={"acceleration_g": [acceleration]}, walls=walls))
    run = case.point
    assert (run.constants.youngs_modulus == 3.2e9) == (acceleration == 5)
    impacts = run.constants.impacts
    assert (impacts.speed, impacts.radius, impacts.density) == pytest.approx((0.5, 1.25e-3, 1190))
    found = tuple(rebounds(run.deck_text(), impacts))
    assert found == pytest.approx((0.8, 0.7), abs=1e-6)


@pytest.mark.parametrize("modulus", [5e7, 3.2e9])
def test_a_bed_on_a_panel_has_its_restitution_at_its_speed_with_any_modulus(tmp_path, modulus):
    bed = bed_of(coupon(), 0.5, cells=2, seed=1)
    files = {"data_file": "start.data", "walls_file": "walls.stl"}
    text = deck_of(StartedBed(bed, modulus, tmp_path, 10), 1e-6, files)
    found = tuple(rebounds(text, bed.constants.impacts))
    assert found == pytest.approx((0.8, 0.8), abs=1e-6)


def test_damping_across_is_that_along_by_the_stiffnesses_as_with_a_constant_restitution():
    constants = cases_of(coupon())[0].point.constants
    of = {name: values for name, *values in constants.deck_values["impacts"]}
    plain = replace(constants, impacts=None)
    for side, material in enumerate(plain.materials):
        _, along, across = contact.contact_forces(material, 1e-6, 1e3, 1e6)
        assert of["gammat"][side] / of["gamman"][side] == pytest.approx(across / along)
        # Mindlin: F_t = 8 G* √(R* δ) s, F_n = 4/3 E* √(R* δ) δ
        shear = 8 * material.effective_shear_modulus / (4 / 3 * material.effective_modulus)
        assert of["kt"][side] / of["kn"][side] == pytest.approx(shear)


def test_law_and_value_are_varied_like_any_other_key():
    laws, values = ["constant", "viscoelastic"], [0.6, 0.7]
    vary = {"particles.restitution.law": laws, "particles.restitution.value": values}
    particles = {"restitution": LAW}
    varied = {"sweep": SMALL["sweep"], "particles": particles, "vary": vary}
    found = [case.point.constants for case in cases_of(VariedCoupon.model_validate(varied))]
    assert [constants.restitution for constants in found] == [0.6, 0.7, 0.6, 0.7]
    assert [constants.impacts is None for constants in found] == [True, True, False, False]


def test_a_mapping_with_a_constant_law_is_the_case_of_its_number():
    one, other = (
        cases_of(coupon(restitution))[0].label
        for restitution in (0.7, {"value": 0.7, "at_m_s": 2, "law": "constant"})
    )
    assert one == other


@pytest.mark.parametrize(
    ("restitution", "key"),
    [
        ({"value": 0.8, "law": "viscoelastic"}, "at_m_s"),
        ({"value": 0.01, "at_m_s": 1, "law": "viscoelastic"}, "value"),
        ({"value": 0.8, "at_m_s": 0, "law": "viscoelastic"}, "at_m_s"),
        ({"value": 0.8, "at_m_s": 1, "law": "plastic"}, "law"),
        ({"at_m_s": 1, "law": "viscoelastic"}, "value"),
    ],
)
def test_a_restitution_that_no_impact_has_is_refused_at_its_key(restitution, key):
    with pytest.raises(ValidationError) as refusal:
        coupon(restitution)
    (mistake,) = mistakes_of(refusal.value, Coupon)
    assert mistake.keys == ("particles", "restitution", key)


def test_spheres_of_several_sizes_have_no_viscoelastic_law():
    with pytest.raises(ValidationError) as refusal:
        coupon(particles={"distribution": {"kind": "normal", "deviation_mm": 0.1}})
    (mistake,) = mistakes_of(refusal.value, Coupon)
    assert mistake.keys == ("particles", "restitution", "law")


def test_the_atlas_holds_for_a_constant_restitution_alone():
    deep = {"depth_mm": 25, "across_flats_mm": 6.35}
    (mistake,) = mistakes_of_coupon(coupon(cell=deep))
    assert mistake.keys == ("particles", "restitution", "law")
    assert not list(mistakes_of_coupon(coupon(LAW | {"law": "constant"}, cell=deep)))
