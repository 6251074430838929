"""Rows of the verification page: each truth is met."""

import pytest

from pidpanel.verification.sound import CASES


@pytest.mark.slow
def test_the_truths_of_the_page_are_met(tmp_path):
    for case in CASES.values():
        for row in case(tmp_path):
            assert row.met, (row.quantity, row.computed, row.reference, row.error)
