"""The paper's law, as printed and corrected."""

import numpy as np
import pytest

from pidpanel.damping import laws
from pidpanel.damping.models import DampingError

FREQUENCY = np.geomspace(5, 2000, 50)


@pytest.mark.parametrize("fill", [0.1, 0.3, 0.5, 0.7, 0.9, 1.0])
def test_the_law_feeds_the_panel_as_printed_and_damps_as_corrected(fill):
    assert (laws.paper_printed(FREQUENCY, fill) < 0).all()
    assert (laws.paper_corrected(FREQUENCY, fill) > 0).all()


def test_the_constants_are_those_of_equation_6():
    # by hand at r = 0.5: 0.5 (−20 + 18.045 − 6.3) 1e-4, 4.1 − 0.3, 0.5 (8.8 − 6.25) 1e-4
    assert laws.paper_constants(0.5) == pytest.approx((-4.1275e-4, 3.8, 1.275e-4))


def test_a3_changes_sign_at_a_fill_of_0_704():
    assert laws.paper_constants(0.703)[2] > 0 > laws.paper_constants(0.705)[2]


def test_the_corrected_law_has_its_hand_worked_values():
    # (1/2π) 4.1275e-4 · 1000^2.8 · e^(−0.1275) = 6.5691e-5 · 2.5119e8 · 0.88029
    assert laws.paper_corrected(1000.0, 0.5) == pytest.approx(14526, rel=1e-4)


def test_at_the_centre_frequencies_a_fifth_damps_more_than_a_tenth():
    # why "10 % is best" does not come out below 1.4 kHz
    low = np.geomspace(20, 1300, 20)
    assert (laws.paper_corrected(low, 0.2) > laws.paper_corrected(low, 0.1)).all()


@pytest.mark.parametrize(
    ("frequency", "fill"), [(4.0, 0.5), (2001.0, 0.5), (100.0, 0.0), (100.0, 1.1)]
)
def test_outside_its_range_the_law_refuses(frequency, fill):
    with pytest.raises(DampingError):
        laws.paper_corrected(frequency, fill)


@pytest.mark.parametrize("fill", [0.1, 0.5, 0.9])
def test_as_printed_it_is_the_corrected_law_of_2_pi_times_the_frequency_with_its_sign_turned(fill):
    # one takes ω and a₁ < 0, the other f for ω and |a₁|
    frequency = np.geomspace(5, 300, 9)
    np.testing.assert_allclose(
        laws.paper_printed(frequency, fill),
        -laws.paper_corrected(2 * np.pi * frequency, fill),
        rtol=1e-12,
    )
