"""Damping beyond its data, weighted by what rests on it and by how far beyond it is."""

import dataclasses
import math

import numpy as np
import pytest

from pidpanel.atlas.groups import ElasticSphere
from pidpanel.damping.atlas import AtlasDamping, atlas_bed
from pidpanel.damping.laws import ConstantDamper
from pidpanel.damping.models import DampingValues, FilledDamper
from pidpanel.damping.table_files import read_columns
from pidpanel.damping.tables import TableDamping
from pidpanel.response.extrapolation import (
    FAR,
    Extrapolation,
    between_regimes,
    extrapolation_of,
)

LINES = np.geomspace(20, 200, 181)


@pytest.fixture
def damper(tmp_path):
    """A table from 20 to 100 Hz and 1 to 50 g, on the first patch."""
    path = tmp_path / "table.csv"
    rows = [f"{f},{gamma},{1000 / gamma}" for f in (20, 100) for gamma in (1, 50)]
    path.write_text(
        "frequency_hz,acceleration_g,equivalent_damping_n_s_m3\n" + "\n".join(rows) + "\n"
    )
    return FilledDamper("lab", TableDamping(read_columns(path), "log"), 1.0)


@dataclasses.dataclass
class Response:
    acceleration_g: np.ndarray
    inside: np.ndarray


def extrapolated(damper, gamma):
    inside = damper.model(LINES, 1.0, gamma).inside
    return extrapolation_of([damper], Response(np.array([gamma]), inside[None]), LINES)


def test_a_line_counts_by_its_distance_from_the_data(damper):
    assert not extrapolated(damper, 20.0).weight[LINES <= 100].any()
    little = extrapolated(damper, 50 * 1.01)
    inside = LINES <= 100
    assert little.weight[inside] == pytest.approx(0.02)  # the first step that reaches the data
    assert extrapolated(damper, 200.0).weight[inside] == pytest.approx(1.0)
    in_motion = extrapolated(damper, 20.0)
    nearest = LINES[inside][-1]
    expected = np.minimum(np.log(LINES[~inside] / nearest) / FAR, 1)
    assert in_motion.weight[~inside] == pytest.approx(expected)


def test_a_line_between_data_counts_by_the_nearer_of_both_sides(damper):
    lines = 20.0 * 2.0 ** np.array([0.0, 0.1, 0.3, 0.7, 1.0, 1.2])
    inside = np.array([False, True, False, False, True, False])
    steady = dataclasses.replace(damper, model=ConstantDamper(equivalent_damping=100.0))
    response = Response(np.array([np.nan]), inside[None])
    weight = extrapolation_of([steady], response, lines).weight
    np.testing.assert_allclose(weight, [0.1, 0, 0.2, 0.3, 0, 0.2], atol=1e-12)


def test_what_the_data_would_have_to_cover_is_named(damper):
    assert extrapolated(damper, 20.0).missing.startswith("lab to 20 g at 10")
    assert extrapolated(damper, 20.0).missing.endswith(" to 200 Hz")
    high = np.geomspace(20, 2000, 181)
    response = Response(np.array([20.0]), damper.model(high, 1.0, 20.0).inside[None])
    assert extrapolation_of([damper], response, high).missing.endswith(" to 2000 Hz")
    # the data end at 100 Hz and have every fill
    for gamma in (60.0, 500.0):
        assert extrapolated(damper, gamma).missing == f"lab to {gamma:g} g at 100 to 200 Hz"
    below = Response(np.array([1234.5]), np.zeros((1, 91), bool))
    assert extrapolation_of([damper], below, LINES[:91]).missing == "lab to 1230 g"
    steady = dataclasses.replace(damper, model=ConstantDamper(equivalent_damping=100.0))
    nowhere = Response(np.array([np.nan]), np.zeros((1, 181), bool))
    missing = extrapolation_of([steady], nowhere, LINES).missing
    assert missing == "lab to 20 to 200 Hz and r = 1"
    whole = extrapolation_of([damper], Response(np.array([30.0]), np.ones((1, 181), bool)), LINES)
    assert whole.missing == "" and not whole.weight.any()


def test_the_share_is_that_of_the_change_in_mean_square():
    weight = np.where(LINES > 100, 0.5, 0.0)
    bare = np.ones((181, 2))
    damped = np.stack([np.where(LINES > 100, 0.2, 1.0), np.where(LINES > 100, 1.0, 0.2)], axis=1)
    share = Extrapolation(weight, "").share_of_change(bare, damped, LINES)
    assert share == pytest.approx([0.5, 0.0], abs=0.01)
    assert Extrapolation(weight, "").share_of_change(bare, bare, LINES).tolist() == [0, 0]
    assert math.isclose(FAR, math.log(2))


def test_more_motion_is_a_change_too():
    # |S₀ − S| is 0.2, 0.2, 0.1, 0.1, of which the last two count
    f, weight = np.arange(4.0), np.array([0.0, 0.0, 1.0, 1.0])
    bare, damped = np.full((4, 1), 0.1), np.array([[0.3], [0.3], [0.0], [0.0]])
    share = Extrapolation(weight, "").share_of_change(bare, damped, f)
    assert share == pytest.approx([0.15 / 0.45])


def of_the_atlas(sphere):
    """A damper of a bed 25 mm deep, half full, with the same C_e and m_a everywhere."""

    def surface(frequency, fill, gamma):
        ones = np.ones(len(frequency))
        return DampingValues(ones, ones, ones, ones > 0)

    bed = atlas_bed(0.8, 0.3, 6e-3, 25e-3, 2e-3, ["flat"])
    return FilledDamper(
        "rubber", AtlasDamping(surface, bed, 1.0, np.ones((2, 3)), sphere=sphere), 0.5
    )


def test_particles_softer_than_those_of_the_atlas_are_named_from_their_first_line_on():
    damper, lines = (
        of_the_atlas(ElasticSphere(1e-3, 1190.0, 1e6, 0.35)),
        np.array([50.0, 100.0, 200.0]),
    )
    response = Response(np.array([20.0]), np.zeros((1, 3), bool))
    missing = extrapolation_of([damper], response, lines).missing
    assert missing == "the atlas to particles as soft as rubber from 50 Hz"


def test_lines_count_at_which_a_bed_of_the_atlas_may_ride_or_cross():
    # W/L of 0.1 to 0.5, with L = (1 − 0.94 r) depth
    stroke = 20 * 9.80665 / (2 * np.pi * LINES) ** 2 / (0.025 * (1 - 0.94 * 0.5))
    response = Response(np.array([20.0]), np.ones((1, 181), bool))
    found = between_regimes([of_the_atlas(None)], response, LINES)
    np.testing.assert_array_equal(found.weight, (stroke > 0.1) & (stroke < 0.5))
    assert 0 < found.weight.sum() < 181
