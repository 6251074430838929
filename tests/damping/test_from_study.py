"""The readings that a study names: each its own, none in place of another."""

from typing import get_args

import numpy as np
import pytest

from pidpanel.damping.from_study import reading_of
from pidpanel.damping.laws import PaperLaw, paper_corrected, paper_printed
from pidpanel.damping.readings import DampingError
from pidpanel.report.text import READINGS
from pidpanel.study import load_study
from pidpanel.study.damping import Reading


@pytest.fixture(scope="module")
def study(tmp_path_factory, write_study, table_values):
    return load_study(write_study(tmp_path_factory.mktemp("readings"), "table", table_values()))


@pytest.mark.parametrize(
    ("name", "law"), [("paper_corrected", paper_corrected), ("paper_printed", paper_printed)]
)
def test_a_law_is_the_one_that_is_named(study, name, law):
    # red: `printed=False` for both
    reading = reading_of(name, study, None)
    assert isinstance(reading, PaperLaw)
    assert reading(100.0, 0.5, 20.0).equivalent_damping == law(100.0, 0.5)


@pytest.mark.parametrize("name", ["dem", "dashpot"])
def test_a_reading_that_is_not_there_is_no_other_one(study, name):
    # red: a law for every name that is left over
    with pytest.raises(DampingError, match=f"reading {name}: no such reading, or its file"):
        reading_of(name, study, None)


def test_a_table_is_a_reading_with_motion_and_errors(study):
    reading = reading_of("table", study, None)
    assert reading.depends_on_acceleration
    assert (reading(np.array([80.0]), 0.5, 30.0).equivalent_damping_error > 0).all()


def test_every_reading_has_a_name_on_the_page():
    # red: a line of READINGS left out
    assert set(READINGS) == set(get_args(Reading))
