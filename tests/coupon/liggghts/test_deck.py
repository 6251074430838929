"""Decks and data files as text."""

from pathlib import Path

import jinja2
import numpy as np
import pytest

from pidpanel.coupon.liggghts import deck, start_files
from tests.coupons import small_cases

GOLDEN = Path(__file__).parent / "golden" / "shake"


def golden_run():
    return small_cases()[0].runs[0]


def test_the_rendered_deck_is_the_recorded_one_command_by_command():
    text = golden_run().deck_text()
    recorded = (GOLDEN / "shake_1.in").read_text()
    # after it the solver was given its runs
    commands = deck.without_comments(recorded)
    assert commands.startswith(deck.without_comments(text) + "\nprint ")


def test_a_variable_that_nobody_set_is_refused_by_name():
    values = golden_run().deck_values()
    del values["time_step"]
    with pytest.raises(jinja2.UndefinedError, match="'time_step' is undefined"):
        deck.render("shake.in.j2", values)


def test_numbers_are_written_so_that_they_read_back_the_same(tmp_path):
    (tmp_path / "one.j2").write_text("{{ x }}")
    for x in (0.1, 1 / 3, 4e-6, 98.0665, 1e9):
        # 15 digits, one less than would always do: LIGGGHTS itself prints 15
        assert float(deck.render("one.j2", {"x": x}, tmp_path)) == pytest.approx(x, rel=1e-15)


def test_a_data_file_holds_every_sphere_once():
    positions = np.array([[0.0, 1e-3, 2e-3], [3e-3, 4e-3, 5.123456789e-3]])
    text = start_files.data_file(
        positions, np.array([2e-3, 3e-3]), 1190.0, np.array([[0, 1], [0, 1], [0, 1]])
    )
    assert "2 atoms\n2 atom types" in text
    rows = [line.split() for line in text.split("Atoms\n\n")[1].splitlines()]
    assert [row[:4] for row in rows] == [["1", "1", "0.002", "1190"], ["2", "1", "0.003", "1190"]]
    np.testing.assert_allclose([[float(v) for v in row[4:]] for row in rows], positions)
