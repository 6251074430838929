"""Errors of damping models under broadband motion."""

import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pidpanel.damping.broadband import EXACT, PAPER_LAW, SINGLE_TONES, BroadbandError
from pidpanel.response.model_error import (
    load_error_of,
    log_error,
    model_error_of,
    with_model_error,
)
from pidpanel.solve.uncertainty import StandardErrors

PSD = np.array([[8.0, 2.0], [8.0, 0.0]])


def response(psd):
    rms = np.sqrt(psd.sum(axis=0))
    return SimpleNamespace(response=SimpleNamespace(acceleration_psd=psd, acceleration_rms=rms))


def case(*errors, dead=None):
    dampers = [SimpleNamespace(model=SimpleNamespace(broadband_error=error)) for error in errors]
    return SimpleNamespace(dampers=dampers, dead_weight=dead, bare=response(4 * PSD))


def test_the_error_of_single_tones_is_a_share_of_the_effect_of_the_damping():
    error = model_error_of(case(SINGLE_TONES, EXACT), response(PSD))
    share, rest = SINGLE_TONES
    effect = np.array([[1, 1], [1, 0]]) * share * np.log(4)
    assert error.log_psd == pytest.approx(np.hypot(effect, 2 * rest))
    assert error.log_rms == pytest.approx([np.hypot(share * np.log(2), rest)] * 2)
    beside_dead = model_error_of(case(SINGLE_TONES, dead=response(PSD)), response(PSD))
    assert beside_dead.log_rms == pytest.approx([rest] * 2)


def test_the_error_of_the_law_does_not_depend_on_its_effect():
    error = model_error_of(case(PAPER_LAW), response(PSD))
    assert error.log_psd == pytest.approx(2 * PAPER_LAW.of_rms)
    assert error.log_rms == pytest.approx(PAPER_LAW.of_rms)


def test_linear_dampers_and_the_bare_panel_have_none():
    assert model_error_of(case(EXACT), response(PSD)) is None
    assert model_error_of(case(), response(PSD)) is None


def test_a_point_at_rest_has_the_part_without_effect_alone():
    undamped, damped = np.array([2.0, 0.0, 0.5, 0.0]), np.array([0.0, 1.0, 0.25, 0.0])
    error = log_error(BroadbandError(4 / np.log(2), 3.0), undamped, damped)
    assert error == pytest.approx([3, 3, 5, 3])


def test_both_errors_are_independent():
    first, second = (StandardErrors(np.full((1, 1), e), np.full(1, e), np.ones(1)) for e in (3, 4))
    both = with_model_error(first, second)
    assert both.log_psd.item() == both.log_rms.item() == pytest.approx(5)
    assert with_model_error(None, second) is second and with_model_error(first, None) is first
    assert with_model_error(None, None) is None


def test_the_errors_are_those_of_the_scenarios_that_set_them():
    # the table of 16 scenarios at three points
    root = Path(__file__).parents[2]
    page = (root / "benchmarks" / "single_tones.md").read_text()
    rows = [line.split("|") for line in page.splitlines() if line.startswith("| acrylic")]
    assert len(rows) == 16
    shares = np.array([cells[4].split("/") for cells in rows], float)
    assert np.sqrt(np.mean(shares**2)) == pytest.approx(SINGLE_TONES.of_effect, abs=0.03)
    of_law = np.array([cells[5].strip(" %").split("/") for cells in rows], float) / 100
    assert np.sqrt(np.mean(np.log(1 + of_law) ** 2)) == pytest.approx(PAPER_LAW.of_rms, abs=0.01)
    models = (root / "docs" / "damping_models.md").read_text()
    stated = re.search(r"single tones.* (\d+) % of the effect, and (\d+) % of g rms", models)
    assert [int(number) / 100 for number in stated.groups()] == pytest.approx(SINGLE_TONES)


def test_the_error_of_a_load_is_that_of_the_nearest_mode_and_half_of_it_in_g_rms():
    basis = SimpleNamespace(
        natural_frequency=np.array([10.0, 40.0, 90.0]),
        is_residual=np.array([False, False, True]),
        point_names=("A",),
    )
    panel = SimpleNamespace(
        basis=basis,
        frequency=np.array([10.0, 19.0, 21.0, 40.0]),
        load_error=np.array([0.02, 0.1]),
        has_independent_loads=False,
    )
    psd = np.array([[1.0], [0.0], [0.0], [0.0]])
    error = load_error_of(panel, SimpleNamespace(acceleration_psd=psd))
    assert error.log_psd[:, 0].tolist() == [0.02, 0.02, 0.1, 0.1]
    assert error.log_rms == pytest.approx([0.01])
    panel.load_error = None
    assert load_error_of(panel, SimpleNamespace(acceleration_psd=psd)) is None
