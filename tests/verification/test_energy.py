"""Statistical energy against sums over the modes of simply supported rectangles."""

import numpy as np
import pytest

from pidpanel.energy.response import DamperLoad
from tests.energy.test_response import difference_db

pytestmark = pytest.mark.verification

BANDS = {
    "paper": (range(32, 40, 2), 0.072, "1.5 m × 1 m, 4 kg/m², 3273 N m"),
    "sandwich": (range(33, 38, 2), 0.06, "2.1 m × 1.5 m, orthotropic core"),
    "plate of 2 mm": (range(28, 35, 2), 0.1, "1.2 m × 0.8 m, 5.4 kg/m², 51.9 N m, "
                      "below coincidence"),
}  # fmt: skip


@pytest.mark.parametrize("name", BANDS)
def test_area_means_by_energy_are_those_of_the_modes(record, name):
    numbers, tolerance, text = BANDS[name]
    for number in numbers:
        centre = 10 ** (number / 10)
        difference, *_ = difference_db(name, centre)
        record(
            f"mean square acceleration, third octave at {centre:.0f} Hz",
            10 ** (difference / 10), 1.0, case=f"{name}: {text}", method="statistical energy",
            source="sum over all modes, products of sines, ζ = 1 %", tolerance=tolerance,
        )  # fmt: skip


def test_a_loss_of_dampers_all_over_is_that_of_the_modes(record):
    centre = 10**3.3
    load = DamperLoad(0.01 * 4.0 * 2 * np.pi * centre * 1.5)
    difference, *_ = difference_db("paper", centre, load, loss=0.03)
    record(
        "mean square acceleration, C_e/(m″ω) = 0.01", 10 ** (difference / 10), 1.0,
        case="paper, dampers all over", method="statistical energy, η_d = C_e/(m″ω)",
        source="sum over all modes with η = 0.03", tolerance=0.072,
    )  # fmt: skip
