"""What a search makes small, against the solver and other stages."""

import numpy as np
import pytest
from random_panels import RandomPanel

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.optimise.objectives import (
    Objective,
    accelerations,
    oscillators,
    spread_vertices,
    stresses,
)
from pidpanel.optimise.reduced_panel import ReducedPanel
from pidpanel.severity.oscillators import response_spectrum
from pidpanel.solve import layouts
from pidpanel.solve.layout import AttachedDamper, DamperLayout
from pidpanel.solve.model import root_mean_square
from pidpanel.solve.panel import ModalPanel
from pidpanel.solve.receptances import patch_stiffness
from pidpanel.solve.stress import QUANTITIES, Layers, layer_psd

PLACES = (0, 7)
POINTS = np.arange(3)


@pytest.fixture(scope="module")
def panel():
    return RandomPanel(3)


def motions(panel):
    """(3, 6, n) w, and made-up curvatures and shear angles of the shapes at the points."""
    other = np.random.default_rng(1).normal(size=(3, 5, panel.points.shape[1]))
    return np.concatenate([panel.points[:, None], other], axis=1)


@pytest.fixture(scope="module")
def response(panel):
    """Of two dampers, with all motions at the points."""
    fillings = [panel.fillings[0], panel.fillings[1]]
    loads = [AttachedDamper(p, f.damping, False) for p, f in zip(PLACES, fillings, strict=True)]
    model = ModalPanel(panel.basis, panel.patches, panel.frequency, motions(panel), panel.frequency)
    (answer,) = layouts(model, panel.excitation, [DamperLayout(tuple(loads))])
    return answer.response


LAYERS = Layers(("a", "b"), np.zeros((2, 3, 3)), np.random.default_rng(2).normal(size=(2, 3, 3)))


@pytest.mark.parametrize(
    "objective",
    [
        accelerations(POINTS),
        oscillators(POINTS, np.array([60.0, 120.0]), 10.0),
        stresses(POINTS[[0, 2]], LAYERS, 6),
    ],
    ids=["accelerations", "oscillators", "stresses"],
)
def test_the_search_has_the_mean_squares_of_the_solver(panel, response, objective):
    at_points = motions(panel) if objective.motion.shape[1] == 6 else motions(panel)[:, :1]
    reduced = ReducedPanel(
        panel.frequency, panel.basis, panel.patches, objective.rows(at_points), panel.excitation,
        outputs=objective.outputs(panel.frequency), precision=np.complex128,
    )  # fmt: skip
    read = [f.damping(panel.frequency, np.nan)[:2] for f in panel.fillings]
    s = np.array([patch_stiffness(panel.frequency, *values) for values in read])
    added = reduced.additions(PLACES[:1], s[:1], np.array(PLACES[1:]), s[1:]).mean_square[0]
    known = response
    if objective.motion.shape[1] == 1:
        known = type(response)(response.frequency, response.cross_psd[:, :, :1, :1])
    np.testing.assert_allclose(added, objective.mean_square(known), rtol=1e-6)


def test_stresses_are_those_of_the_response_stage(response):
    psd = layer_psd(response, LAYERS)[..., list(QUANTITIES).index("von_mises")]
    rms = root_mean_square(response.frequency, psd.reshape(len(psd), -1)).reshape(3, 2)
    square = stresses(POINTS, LAYERS, 6).mean_square(response)
    np.testing.assert_allclose(np.sqrt(square).reshape(3, 2), rms, rtol=1e-9)


def test_oscillators_are_those_of_the_severity_stage(response):
    natural = np.array([60.0, 120.0])
    square = oscillators(POINTS, natural, 10.0).mean_square(
        type(response)(response.frequency, response.cross_psd[:, :, :1, :1])
    )
    rms = response_spectrum(
        response.frequency, response.acceleration_psd / STANDARD_GRAVITY**2, natural, 10.0
    )
    # the stage adds lines at the resonance of the oscillator
    np.testing.assert_allclose(np.sqrt(square).reshape(3, 2) / STANDARD_GRAVITY, rms.T, rtol=0.02)


def test_what_is_said_is_the_acceleration_in_g_and_three_times_the_stress_in_mpa(response):
    objective = accelerations(POINTS)
    assert isinstance(objective, Objective)
    alone = type(response)(response.frequency, response.cross_psd[:, :, :1, :1])
    said = objective.scale * np.sqrt(objective.mean_square(alone))
    np.testing.assert_allclose(said, response.acceleration_rms / STANDARD_GRAVITY, rtol=1e-6)
    assert stresses(POINTS, LAYERS, 6).scale * 2e6 == pytest.approx(6.0)  # of 2 MPa rms


def test_the_error_is_that_of_the_point_of_the_largest_and_of_a_mean_by_shares(response):
    error = np.array([0.1, 0.2, 0.4])
    alone = type(response)(response.frequency, response.cross_psd[:, :, :1, :1])
    square = accelerations(POINTS).mean_square(alone)
    largest = int(np.argmax(square))
    assert accelerations(POINTS).log_error(alone, error) == pytest.approx(error[largest])
    of_mean = accelerations(POINTS, is_largest=False)
    assert of_mean.log_error(alone, error) == pytest.approx(square @ error / square.sum())
    assert of_mean.mean_square(alone) == pytest.approx([square.mean()])
    natural, points = np.array([60.0, 120.0]), np.array([2, 0])
    for objective, answer in (
        (oscillators(points, natural, 10.0), alone),
        (stresses(points, LAYERS, 6), response),
    ):
        point = points[np.argmax(objective.mean_square(answer)) // 2]
        assert objective.log_error(answer, error) == pytest.approx(error[point])


def test_vertices_are_spread_from_the_first_to_the_farthest_from_all_before():
    position = np.array([[0, 0], [1.05, 0], [1, 1.1], [0, 1], [0.5, 0.5]])
    assert spread_vertices(position, 3).tolist() == [0, 2, 1]
    assert spread_vertices(position, 9).tolist() == [0, 2, 1, 3, 4]
    many = spread_vertices(np.random.default_rng(0).uniform(size=(60, 2)))
    assert len(set(many.tolist())) == 24
