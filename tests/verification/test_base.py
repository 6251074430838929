"""Base motion against closed forms."""

import pytest

from pidpanel.verification.base import CASES


@pytest.mark.parametrize("name", CASES)
def test_base_motion_meets_its_closed_forms(name, tmp_path):
    rows = CASES[name](tmp_path)
    assert rows and [row.quantity for row in rows if not row.met] == []
