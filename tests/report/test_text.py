"""Numbers are written with their digits, their signs and their units."""

import pytest

from pidpanel.report import text


@pytest.mark.parametrize(
    ("value", "written"),
    [
        (0.0, "0.00"),
        (99999.0, "99999"),
        (0.99996, "1.00"),
        (9.998, "10.0"),
        (99.97, "100"),
        (2.5e6, "2.50·10⁶"),
        (-0.05, "−0.0500"),
        (-2e-7, "−2.00·10⁻⁷"),
    ],
)
def test_numbers_keep_three_digits(value, written):
    assert text.number(value) == written


def test_a_value_without_an_error_is_written_alone():
    assert text.with_error(1.234, 0.0) == "1.23"
    assert text.with_error(float("nan"), 1.0) == "–"


def test_units_of_the_tables_are_written_in_one_form():
    assert [text.unit(name) for name in ("kg/m2", "m2/Pa2", "microstrain", "1", "N m")] == [
        "kg/m²", "m²/Pa²", "µm/m", "–", "N m",
    ]  # fmt: skip
