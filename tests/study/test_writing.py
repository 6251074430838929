"""A study as a mapping: numbers of any library are numbers; what no file can have is one line."""

import datetime
import decimal
import fractions
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from pidpanel.api import Model
from pidpanel.paths import STUDIES
from pidpanel.study import StudyError
from pidpanel.study.values import plain
from pidpanel.study.writing import values_of


def _study(**panel):
    values = values_of(STUDIES / "l_panel.yaml")
    return {**values, "panel": {**values["panel"], **panel}}


def _endless():
    mapping, entries = {}, []
    mapping["damping_ratio"] = mapping
    entries.append(entries)
    return mapping, entries, [mapping, entries]


@pytest.mark.parametrize(
    "number",
    [
        0.02, np.float64(0.02), np.longdouble(0.02), np.array(0.02), decimal.Decimal("0.02"),
        fractions.Fraction(1, 50), type("Ratio", (float,), {})(0.02),
    ],
)  # fmt: skip
def test_numbers_of_any_library_are_numbers(number):
    assert Model(_study(damping_ratio=number)).study.panel.damping_ratio == 0.02


def test_numbers_that_a_32_bit_number_has_keep_them():
    assert plain(np.float32(0.25)) == 0.25
    assert plain({7: [np.int8(3), np.True_, range(2), np.arange(2.0)], "a": Path("b/c.csv")}) == {
        "7": [3, True, [0, 1], [0.0, 1.0]], "a": "b/c.csv",
    }  # fmt: skip
    assert plain(datetime.date(2026, 1, 2)) == "2026-01-02"


@pytest.mark.parametrize(
    "value",
    [
        object(), len, int, b"x", bytearray(b"x"), {1}, 1j, np.complex128(1), np.clongdouble(1),
        pd.Series([0.02]), (entry for entry in "ab"), np.array([object()]), decimal.Decimal("inf"),
        float("nan"), float("inf"), np.float32("inf"), *_endless(), {b"x": 1}, {(1, 2): 1},
        {None: 1},
    ],
    ids=lambda value: type(value).__name__,
)  # fmt: skip
def test_a_value_that_no_file_can_have_is_refused_with_its_key(value):
    with pytest.raises(StudyError, match=r"^panel(\.damping_ratio.*)?: |^panel\.damping_") as told:
        Model(_study(damping_ratio=value))
    assert len(str(told.value).splitlines()) == 1
    model = Model("l_panel.yaml")
    with pytest.raises(StudyError, match=r"^panel"):
        model.changed({"panel.damping_ratio": value})


def test_a_key_of_a_change_is_text():
    with pytest.raises(StudyError, match="7: a key must be text"):
        Model("l_panel.yaml").changed({7: 1})
