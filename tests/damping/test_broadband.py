"""C_e of tones under broadband motion: limits that hold for any constants."""

import numpy as np

from pidpanel.damping.broadband import (
    broadband_share,
    broadband_share_error,
    broadband_stroke,
    floor_load,
)

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


def test_an_upright_bed_that_rides_dissipates_as_under_a_tone_and_a_heavier_flat_one_less():
    # C_e of the tone gives g rms within its errors at r = 0.92; under 4 g it was 9 % too low
    upright, flat, heavier = (floor_load(*pair) for pair in ((0.0, 1.0), (1.0, 1.0), (4.0, 4.0)))
    riding = STROKE[STROKE < 1e-2]
    np.testing.assert_allclose(broadband_share(riding, 0.9, upright), 1, atol=1e-3)
    assert (broadband_share(riding, 0.9, heavier) < broadband_share(riding, 0.9, flat)).all()


def test_the_share_is_known_where_its_constants_were_set():
    # riding beds under 1 g; beds that cross, upright and heavier ones have an error
    riding = STROKE[STROKE < 1e-2]
    np.testing.assert_allclose(broadband_share_error(riding, 1.0), 0, atol=1e-3)
    for stroke, load in ((STROKE[-1:], 1.0), (riding, 0.0), (riding, floor_load(2.0, 2.0))):
        assert (broadband_share_error(stroke, load) > 0.05).all()
