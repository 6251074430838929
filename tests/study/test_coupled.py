"""What the reading coupled requires of the rest of a study."""

import copy

import pytest
import yaml

from pidpanel.paths import WORKFLOW

SMOKE = yaml.safe_load((WORKFLOW / "studies" / "smoke.yaml").read_text())


def values():
    found = copy.deepcopy(SMOKE)
    found["damping"] = {"readings": ["dem", "coupled"]}
    return found


def with_constants(found):
    found["dampers"] = {"pot": {"equivalent_damping_n_s_m3": 900}}
    found["scenarios"]["fill"]["damper"] = "pot"


@pytest.mark.parametrize(
    ("change", "says"),
    [
        (lambda found: found["response"].update(radiation="one_side"),
         "the reading 'coupled' is only allowed with radiation: none"),
        (lambda found: found["response"].update(modal_damping="diagonal"),
         "the reading 'coupled' is only allowed with modal_damping: full"),
        (with_constants, "the reading 'coupled' needs a coupon; damper pot has none"),
    ],
)  # fmt: skip
def test_what_panel_and_particles_cannot_be_integrated_with_is_told(refusal, change, says):
    # red: a check left out of `_mistakes_of_coupled`
    found = values()
    change(found)
    lines, _ = refusal(found)
    assert [line.split(": ", 1)[1] for line in lines] == [
        f"damping.readings = [dem, coupled]: {says}"
    ]
