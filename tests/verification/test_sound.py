"""Rows of the verification page: each truth is met."""

import pytest

from pidpanel.verification.sound import CASES


@pytest.mark.slow
def test_the_truths_of_the_page_are_met(tmp_path):
    # red: tabulate_added_mass(5.0, …) without / (2 * np.pi); cosine for √(1 − cosine²)
    for case in CASES.values():
        for row in case(tmp_path):
            assert row.met, (row.quantity, row.computed, row.reference, row.error)
