"""The paper's law read in the two ways: rad/s as printed, Hz as corrected."""

import numpy as np
import pytest

from pidpanel.damping import laws


@pytest.mark.parametrize("fill", [0.1, 0.5, 0.9])
def test_as_printed_it_is_the_corrected_law_of_2_pi_times_the_frequency_with_its_sign_turned(fill):
    # one takes ω and a₁ < 0, the other f for ω and |a₁|
    # red: equation_5(2 * np.pi * f, …) → equation_5(f, …) in `paper_printed`
    frequency = np.geomspace(5, 300, 9)
    np.testing.assert_allclose(
        laws.paper_printed(frequency, fill),
        -laws.paper_corrected(2 * np.pi * frequency, fill),
        rtol=1e-12,
    )
