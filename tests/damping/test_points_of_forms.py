"""Where the closed form finds the cases of a surface."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping import forms
from pidpanel.damping.laws import paper_corrected
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import AXES, ERROR, PARTICLE_MASS, VALUE

MASS_PER_FILL, DEPTH = 13.0, 0.025
FILLS, FREQUENCIES = (0.2, 0.5, 0.8), (60.0, 200.0, 500.0, 900.0)
AWAY = 0.1 * np.array([1, -1, -1, 1, 1, -1, -1, 1, 1, -1, -1.5, 1])


def cases():
    """Cases e^±0.1 beside the paper's law, one e^−0.15."""
    r, f = (g.ravel() for g in np.meshgrid(FILLS, FREQUENCIES, indexing="ij"))
    value = [float(paper_corrected(one, fill)) for one, fill in zip(f, r, strict=True)]
    value = np.array(value) * np.exp(AWAY)
    return pd.DataFrame(
        {"fill_fraction": r, "frequency_hz": f, "acceleration_g": 5.0 + np.arange(12),
         VALUE: value, ERROR: 0.05 * value, PARTICLE_MASS: MASS_PER_FILL * r}
    )  # fmt: skip


@pytest.fixture(scope="module")
def surface():
    # the law exceeds the bound of an inelastic bed, which the cases themselves lift
    return DampingSurface.from_frame(cases())


def test_cases_lie_where_their_motion_and_gap_say(surface):
    # W = Γg/ω² over depth (1 − r), h = 1 − 1/Γ², ln η = ln C_e/(m₁ r ω)
    # red: level * STANDARD_GRAVITY / omega**2 → * in `points_of`
    points, log_eta = forms.points_of(surface, DEPTH)
    frame = cases()
    r, f, level = (frame[axis].to_numpy() for axis in AXES)
    displacement = level * 9.80665 / (2 * np.pi * f) ** 2
    np.testing.assert_allclose(points.stroke_over_gap, displacement / (0.025 * (1 - 0.94 * r)))
    np.testing.assert_allclose(points.onset, 1 - 1 / level**2)
    eta = frame[VALUE] / (MASS_PER_FILL * r * 2 * np.pi * f)
    np.testing.assert_allclose(np.exp(log_eta), eta)


def test_a_full_cell_keeps_a_gap():
    # 0.06 of the depth; red: 1 - PRESSED * r → 1 - r in `clear_gap`
    full = DampingSurface.from_frame(cases().assign(fill_fraction=1.0))
    points, _ = forms.points_of(full, DEPTH)
    frame = cases()
    omega = 2 * np.pi * frame["frequency_hz"].to_numpy()
    displacement = frame["acceleration_g"].to_numpy() * 9.80665 / omega**2
    np.testing.assert_allclose(points.stroke_over_gap, displacement / (0.025 * 0.06))
