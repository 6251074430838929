"""C_e of tones under broadband motion: limits that hold for any constants."""

import numpy as np

from pidpanel.damping.broadband import broadband_share, broadband_stroke

STROKE = np.geomspace(1e-4, 1e3, 141)


def test_strokes_are_shorter_only_near_the_crossing():
    # a bed that hardly moves, and one that always crosses, do not depend on the largest strokes
    ratio = broadband_stroke(STROKE) / STROKE
    assert (ratio <= 1).all() and ratio.min() < 0.7
    np.testing.assert_allclose(ratio[[0, -1]], 1, atol=2e-3)
    assert (np.diff(broadband_stroke(STROKE)) > 0).all()  # one tone for each frequency


def test_less_is_left_of_the_damping_of_fuller_cells():
    # a single particle feels no others: below the crossing it dissipates as under a tone
    assert (broadband_share(STROKE, 0.9) < broadband_share(STROKE, 0.1)).all()
    assert (broadband_share(STROKE, 0.1) < 1).all()
    np.testing.assert_allclose(broadband_share(STROKE[:1], 0.0), 1, atol=1e-6)
