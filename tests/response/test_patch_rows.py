"""Rows and damping by patch: means over the areas of its dampers."""

from types import SimpleNamespace

import numpy as np
import pytest

from pidpanel.response.cases import SolvedCase
from pidpanel.response.panel import ResponsePanel
from pidpanel.response.tables import damping_on_patches, patch_rows

AREA = np.array([1.0, 3.0, 2.0])
PATCH = np.array([1, 1, 0])
"""Of the dampers: two parts of the second patch, and the first patch."""

MOTION = np.array([3.0, 4.0, 6.0])
BARE = SimpleNamespace(bare_patch_acceleration_g=2 * MOTION)
FILLED = {
    "b": SimpleNamespace(name="steel", fill_fraction=0.5, mass_per_area=5),
    "a": SimpleNamespace(name="acrylic", fill_fraction=0.8, mass_per_area=7),
}


def panel(by_element=False):
    made = SimpleNamespace(
        basis=SimpleNamespace(patch_names=["a", "b", "c"]),
        carriers=PATCH,
        carrier_patches=SimpleNamespace(area=AREA),
        load_area=lambda _response: AREA,
        by_element=by_element,
        frequency=np.arange(1.0, 5.0),
    )
    made.bare_motion_g = lambda bare, patch: ResponsePanel.bare_motion_g(made, bare, patch)
    return made


def case(filled=FILLED):
    dampers = [FILLED[patch] for patch in ("b", "b", "a")]
    made = SimpleNamespace(scenario=SimpleNamespace(dampers=filled), dampers=dampers, bare=BARE)
    made.masses = lambda area: SolvedCase.masses(made, area)
    return made


RESPONSE = SimpleNamespace(
    patches=np.arange(3),
    acceleration_g=np.array([1.0, 2.0, 5.0]),
    patch_acceleration_g=MOTION,
    cell_acceleration_g=np.array([[0.5, 9.0], [0.7, 8.0], [0.1, 0.2]]),
    inside=np.array([[1, 1, 0, 1], [1, 0, 1, 1], [1, 1, 1, 0]], bool),
    equivalent_damping=np.array([[4.0] * 4, [8.0] * 4, [5.0] * 4]),
    apparent_mass=np.array([[1.0] * 4, [3.0] * 4, [7.0] * 4]),
    response=None,
)


@pytest.mark.parametrize(("by_element", "extremes"), [(False, (0.5, 9.0)), (True, (3.0, 4.0))])
def test_a_patch_of_several_dampers_has_their_sums_and_mean_squares(by_element, extremes):
    second, first = patch_rows(panel(by_element), case(), RESPONSE)
    assert (second["patch"], second["damper"], second["fill_fraction"]) == ("b", "steel", 0.5)
    assert (first["patch"], first["damper"], first["fill_fraction"]) == ("a", "acrylic", 0.8)
    assert (second["area_m2"], second["mass_kg"]) == (4.0, 20.0)
    assert (first["area_m2"], first["mass_kg"]) == (2.0, 14.0)
    assert second["damping_read_at_g"] == pytest.approx(np.sqrt((1 + 3 * 4) / 4))
    assert second["patch_motion_g"] == pytest.approx(np.sqrt((9 + 3 * 16) / 4))
    assert second["bare_patch_motion_g"] == pytest.approx(np.sqrt(9 + 3 * 16))
    assert (second["lowest_element_motion_g"], second["highest_element_motion_g"]) == extremes
    assert second["outside_run_points_share"] == pytest.approx(0.5)
    assert first["outside_run_points_share"] == pytest.approx(0.25)


def test_the_damping_of_a_patch_is_the_mean_over_its_area():
    found = damping_on_patches(panel(), case(), RESPONSE)
    np.testing.assert_allclose(found["equivalent_damping"][:, 0], [5, (4 + 3 * 8) / 4, 0])
    np.testing.assert_allclose(found["apparent_mass"][:, 0], [7, (1 + 3 * 3) / 4, 0])
    assert found["inside"].tolist() == [[1, 1, 1, 0], [1, 0, 0, 1], [1, 1, 1, 1]]
