"""What is stated of a search."""

from dataclasses import replace

import numpy as np
import pytest
from random_panels import RandomPanel

from pidpanel.optimise.proposal import damper_rows


def test_a_damper_without_damping_reduces_as_its_dead_weight_and_another_more():
    panel = RandomPanel(1)
    undamped = panel.filling("mass", 0.0, panel.fillings[0].mass_per_area)
    panel.fillings = [panel.fillings[0], replace(undamped, damper="mass")]
    rows = damper_rows(panel.problem(), panel.fillings)
    assert rows["reduction_db of mass"] == pytest.approx(rows["dead_weight_reduction_db of mass"])
    assert rows["reduction_db of damper 0"] > rows["dead_weight_reduction_db of damper 0"]
    assert np.isfinite(list(rows.values())).all()
