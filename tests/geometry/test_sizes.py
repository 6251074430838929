"""What a draw of diameters takes from its generator."""

import numpy as np

from pidpanel.geometry.sizes import Sizes


def test_no_more_numbers_are_drawn_than_are_needed():
    # the beds behind the labels depend on it
    one, other = np.random.default_rng(0), np.random.default_rng(0)
    found = Sizes("normal", 1e-3, 3e-3).draw(1, one)
    assert found == [other.normal(2e-3, 0.5e-3)]
    assert one.random() == other.random()
