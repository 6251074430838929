"""The range of cases: the hull of r, ln f and ln Γ, whatever they spread along."""

import numpy as np
import pytest

from pidpanel.damping.surface import SimulatedRange


@pytest.mark.parametrize("slope", [0.0, 1.0])
def test_cases_in_one_plane_have_a_range_in_that_plane(slope):
    # ln Γ = 1 + ln f + slope r
    r, f = (axis.ravel() for axis in np.meshgrid([0.2, 0.5, 0.8], [20.0, 50.0, 200.0]))
    cases = np.stack([r, f, f * np.exp(1 + slope * r)], axis=1)
    inside = np.array([0.35, 60.0, 60.0 * np.exp(1 + slope * 0.35)])
    off = inside * [1, 1, 1.1]
    assert SimulatedRange(cases).contains(np.array([inside, off])).tolist() == [True, False]


def test_a_solid_range_ends_at_its_faces():
    # a tetrahedron, to a millionth of a logarithm
    cases = np.array([[0.0, 1.0, 1.0], [1.0, 1.0, 1.0], [0.0, np.e, 1.0], [0.0, 1.0, np.e]])
    face = np.array(
        [[0.2, np.exp(0.3), np.exp(0.5 + d)] for d in np.sqrt(3) * np.array([0.95e-6, 1.05e-6])]
    )
    assert SimulatedRange(cases).contains(face).tolist() == [True, False]
