"""A supported panel in three sines, and functions of the jump over it."""

import pytest

from pidpanel.geometry.plane_waves import condensed
from pidpanel.sound.free_edges import FreePanel
from pidpanel.sound.rectangle import RectangleJumps
from tests.sound.panels import SIDES, sine_panel


@pytest.fixture(scope="module")
def face():
    return condensed(sine_panel([(1, 1), (2, 1), (3, 2)]), 40.0)


@pytest.fixture(scope="module")
def panel():
    return FreePanel.of_jumps(RectangleJumps.of_box([0, 0], SIDES, 14.0), 8.0)
