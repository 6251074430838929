"""What a structure does not go together with is refused at its key, before anything runs."""

import pytest

from pidpanel import Model, StudyError
from tests.structures import COMMON, CURVED

SOUND = COMMON["sound"]
SINE = {"sine": {"frequency_hz": [30, 400], "acceleration_g": 1}}


@pytest.mark.parametrize(
    ("change", "key"),
    [
        ({"sound": {**SOUND, "surroundings": {"wall_m": 0.1}}}, "sound.surroundings"),
        ({"sound": {**SOUND, "field": "plane_wave", "incidence_deg": 30}}, "sound.field"),
        ({"base": SINE}, "structure.shell.supports"),
    ],
)
def test_of_a_free_curved_shell(change, key):
    with pytest.raises(StudyError, match=key):
        Model({"name": "curved", "structure": CURVED, **COMMON, **change})


def test_base_motion_of_modes_from_a_file(structure):
    with pytest.raises(StudyError, match=r"base = .*inertia of its modes is not known"):
        Model({"name": "modes", "structure": structure, **COMMON, "base": SINE})


def test_a_direction_of_the_motion_of_a_panel(panel_model):
    with pytest.raises(StudyError, match=r"base\.direction"):
        panel_model.changed({"base": {**SINE, "direction": [1, 0, 0]}})
