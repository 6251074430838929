"""Additions to layouts against the solver of all layouts."""

import numpy as np
import pytest
from random_panels import RandomPanel

from pidpanel.optimise import reduced_panel as module
from pidpanel.solve import layouts
from pidpanel.solve.dampers import patch_stiffness
from pidpanel.solve.layout import AttachedDamper, DamperLayout
from pidpanel.solve.model import ResponseError
from pidpanel.solve.panel import ModalPanel


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


def test_the_energy_of_the_shapes_is_that_of_the_acceleration_of_points(panel):
    # red: weights of mean squares in place of their roots
    _, energy = module._forces(panel.frequency, panel.basis, panel.excitation, None)
    rms = np.sqrt(np.diag(panel.points @ energy @ panel.points.T))
    assert rms == pytest.approx(solved(panel, (), ()).response.acceleration_rms, rel=1e-9)


def test_places_that_take_more_memory_than_allowed_are_refused(panel, monkeypatch):
    # two complex numbers of 8 bytes for each line, shape, and point or motion of a place
    motions = len(panel.points) + 4 * len(panel.places.lower)
    size = 2 * 8 * panel.frequency.size * panel.points.shape[1] * motions
    monkeypatch.setattr(module, "LARGEST", 1.001 * size)
    panel.reduced(rank=4)
    monkeypatch.setattr(module, "LARGEST", 0.999 * size)
    with pytest.raises(ResponseError, match=f"{len(panel.places.lower)} places take up to"):
        panel.reduced(rank=4)


def test_forces_may_have_more_parts_on_some_lines(panel, monkeypatch):
    # a part that is nothing, on the second half of the lines. red: min of the parts
    plain, factors = panel.reduced(), module._force_factors

    def more(excitation, frequency):
        found = factors(excitation, frequency)
        return np.pad(found, ((0, 0), (0, 0), (0, int(frequency[0] > panel.frequency[0]))))

    monkeypatch.setattr(
        module, "chunks_of_lines", lambda n, _: [slice(0, n // 2), slice(n // 2, n)]
    )
    monkeypatch.setattr(module, "_force_factors", more)
    np.testing.assert_allclose(panel.reduced().bare, plain.bare, rtol=1e-5)
