"""Additions to layouts against the solver of all layouts."""

import copy

import numpy as np
import pytest
from random_panels import RandomPanel

from pidpanel.optimise import reduced_panel as module
from pidpanel.solve import layouts
from pidpanel.solve.layout import AttachedDamper, DamperLayout
from pidpanel.solve.model import ResponseError
from pidpanel.solve.panel import ModalPanel
from pidpanel.solve.receptances import patch_stiffness


@pytest.fixture(scope="module", params=[False, True], ids=["forces", "moving base"])
def panel(request):
    return RandomPanel(0, moving=request.param)


def stiffness(panel, fillings):
    read = [filling.damping(panel.frequency, np.nan)[:2] for filling in fillings]
    return np.array([patch_stiffness(panel.frequency, *values) for values in read])


def solved(panel, places, fillings):
    loads = [AttachedDamper(p, f.damping, False) for p, f in zip(places, fillings, strict=True)]
    model = ModalPanel(panel.basis, panel.patches, panel.frequency, panel.points, panel.frequency)
    (answer,) = layouts(model, panel.excitation, [DamperLayout(tuple(loads))])
    return answer


@pytest.mark.parametrize("places", [(0,), (1, 6), (0, 7, 3)])
def test_a_layout_is_that_of_the_solver(panel, places):
    reduced = panel.reduced(precision=np.complex128)
    fillings = [panel.fillings[k % 2] for k in range(len(places))]
    s = stiffness(panel, fillings)
    added = reduced.additions(places[:-1], s[:-1], np.array(places[-1:]), s[-1:])
    answer = solved(panel, places, fillings)
    rms = np.sqrt(added.mean_square[0])
    assert rms == pytest.approx(answer.response.acceleration_rms, rel=1e-6)
    gamma = np.sqrt(2 * added.patch_mean_square) / 9.80665
    assert gamma == pytest.approx(answer.patch_acceleration_g[-1:], rel=1e-3)  # SEARCH_CUTOFF


def test_four_motions_of_a_place_in_single_precision_give_rms_values_within_half_a_percent(panel):
    s = stiffness(panel, panel.fillings)
    further, added = np.array([6]), s[1:]
    values = [
        panel.reduced(**how).additions((1,), s[:1], further, added).mean_square
        for how in ({"precision": np.complex128}, {"rank": 4})
    ]
    assert np.sqrt(values[1] / values[0]) == pytest.approx(1, abs=5e-3)
    assert np.any(values[1] != values[0])


def test_the_bare_panel_is_that_of_the_solver(panel):
    answer = solved(panel, (), ())
    bare = panel.reduced(precision=np.complex128).bare
    assert np.sqrt(bare) == pytest.approx(answer.response.acceleration_rms, rel=1e-9)


def test_the_psd_of_the_shapes_is_that_of_the_acceleration_of_points(panel):
    weight = module.acceleration_weight(panel.frequency)
    psd = module.bare_psd(panel.frequency, panel.basis, panel.excitation, None)[1]
    energy = np.einsum("f,fij->ij", weight, psd.real)
    rms = np.sqrt(np.diag(panel.points @ energy @ panel.points.T))
    assert rms == pytest.approx(solved(panel, (), ()).response.acceleration_rms, rel=1e-9)


def test_places_that_take_more_memory_than_allowed_are_refused(panel, monkeypatch):
    # S_q, and between points and motions of each place R and S: complex numbers of 8 bytes
    n, places, rows = panel.points.shape[1], len(panel.places.lower), len(panel.points)
    size = 8 * panel.frequency.size * (n**2 + 2 * 4 * places * (4 + rows))
    monkeypatch.setattr(module, "LARGEST", 1.001 * size)
    panel.reduced(rank=4)
    monkeypatch.setattr(module, "LARGEST", 0.999 * size)
    with pytest.raises(ResponseError, match=f"{places} places and {n} shapes take"):
        panel.reduced(rank=4)


def test_in_air_and_with_few_motions_a_layout_is_the_same(panel):
    s = stiffness(panel, panel.fillings)
    few = copy.copy(panel)
    few.patches = panel.patches.subset([1, 6])
    how = {"precision": np.complex128, "rank": 4}
    wide = panel.reduced(**how).additions((1,), s[:1], np.array([6]), s[1:])
    narrow = few.reduced(**how).additions((0,), s[:1], np.array([1]), s[1:])
    np.testing.assert_allclose(narrow.mean_square, wide.mean_square, rtol=1e-9)
    n = panel.points.shape[1]
    for each in (panel, few):
        places = (1, 6) if each is panel else (0, 1)
        in_air = each.reduced(**how, air=np.zeros((n, n)))
        added = in_air.additions(places[:1], s[:1], np.array(places[1:]), s[1:])
        np.testing.assert_allclose(added.mean_square, wide.mean_square, rtol=1e-9)


def test_columns_of_places_are_computed_again_once_they_are_dropped(panel, monkeypatch):
    s = stiffness(panel, panel.fillings)
    monkeypatch.setattr(module, "CACHE", 0)
    small = panel.reduced(precision=np.complex128, rank=4)
    first = small.additions((0, 3), s, np.array([7]), s[1:]).mean_square
    for place in (1, 6):
        small.additions((place,), s[:1], np.array([9]), s[1:])
    assert len(small._columns) <= 3
    small.clear()
    assert not small._columns
    again = small.additions((0, 3), s, np.array([7]), s[1:]).mean_square
    np.testing.assert_array_equal(first, again)
