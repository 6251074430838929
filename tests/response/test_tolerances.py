"""Errors of particles and fills in g rms: those of a study with the other value."""

import numpy as np
import pytest

from pidpanel import Model
from pidpanel.coupled.from_study import depends_on
from pidpanel.paths import STUDIES
from pidpanel.provenance.digests import by_content, values_digest
from pidpanel.study import StudyError
from pidpanel.study.writing import values_of

VALUES = {"restitution": 0.8, "friction": 0.3, "fill_fraction": 0.5}
PATCHES = {
    "A": {"centre_m": [0.75, 0.5], "size_m": [0.2, 0.2]},
    "B": {"centre_m": [0.35, 0.5], "size_m": [0.2, 0.2]},
}


def study(model="atlas", cell=None, **values):
    """A study whose two patches share their particles; A alone has the fill of the values."""
    values = VALUES | values
    particles = {"diameter_mm": 2, **{key: values[key] for key in ("restitution", "friction")}}
    smoke = values_of(STUDIES / "smoke.yaml")
    return {
        "panel": {**smoke["panel"], "patches": PATCHES},
        "dampers": {"acrylic": {"cell": cell or {}, "particles": particles, "model": model}},
        "sound": {"spectrum": smoke["sound"]["spectrum"]},
        "response": {"frequency_hz": [30, 300]},
        "scenarios": {
            "both": {
                "layout": {
                    "A": {"fill_fraction": values["fill_fraction"]},
                    "B": {"fill_fraction": 0.5},
                }
            }
        },
    }


def rows(**values):
    return Model(study(**values)).summary().set_index("scenario").loc[["both"]]


def stated(value, error):
    return {"value": value, "error": error}


@pytest.fixture(scope="module")
def plain():
    return rows()


@pytest.mark.parametrize(
    ("key", "error"), [("restitution", 0.02), ("friction", 0.03), ("fill_fraction", 0.01)]
)
def test_a_tolerance_is_half_the_difference_of_g_rms_between_both_ends(plain, key, error):
    low, high = (
        rows(**{key: VALUES[key] + side * error})["acceleration_rms_g"].to_numpy()
        for side in (-1, 1)
    )
    found = rows(**{key: stated(VALUES[key], error)})
    expected = 20 * np.abs(np.log10(high / low)) / 2
    # the change of damping is that of both ends; g rms follows it to first order
    np.testing.assert_allclose(found["tolerance_error_db"], expected, rtol=0.05, atol=0.002)
    total = np.hypot(plain["reduction_error_db"], found["tolerance_error_db"])
    np.testing.assert_allclose(found["reduction_error_db"], total, rtol=1e-4)
    np.testing.assert_allclose(found["acceleration_rms_g"], plain["acceleration_rms_g"])
    assert (plain["tolerance_error_db"] == 0).all()


def test_independent_inputs_add_as_squares():
    inputs = {"restitution": 0.05, "fill_fraction": 0.02}
    alone = [
        rows(**{key: stated(VALUES[key], e)})["tolerance_error_db"] for key, e in inputs.items()
    ]
    both = rows(**{key: stated(VALUES[key], error) for key, error in inputs.items()})
    np.testing.assert_allclose(both["tolerance_error_db"], np.hypot(*alone), rtol=1e-4)


def test_no_run_depends_on_a_tolerance_but_the_response_does():
    law = {"at_m_s": 1.0, "law": "viscoelastic"}
    with_errors = {
        "restitution": stated(0.8, 0.05) | law,
        "friction": stated(0.3, 0.05),
        "fill_fraction": stated(0.5, 0.02),
    }
    both = [
        Model(study("coupled", **values)).study
        for values in ({"restitution": {"value": 0.8} | law}, with_errors)
    ]
    first, second = (values_digest(depends_on(each, "both")) for each in both)
    assert first == second
    first, second = (
        by_content([scenario.model_dump() for scenario in each.all_scenarios()]) for each in both
    )
    assert first != second


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"friction": stated(9, 0.1)}, "friction = {value: 9, error: 0.1}: must be from 0 to 5"),
        ({"friction": {"value": 0.3, "eror": 0.1}}, "friction.eror"),
        ({"fill_fraction": stated(0.5, 0.7)}, "fill_fraction.error = 0.7: must be from 0 to 0.5"),
        (
            {"model": "coupled", "cell": {"shape": "square"}, "friction": stated(0.3, 0.1)},
            "cell.shape = square: must be hexagon where particles or fill_fraction have an error",
        ),
    ],
)  # fmt: skip
def test_errors_that_have_no_meaning_are_refused(values, message):
    with pytest.raises(StudyError, match=message.replace("{", r"\{").replace("}", r"\}")):
        Model(study(**values))
