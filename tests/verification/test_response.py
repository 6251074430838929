"""Rows of the verification page: each truth is met; and what no page shows."""

import numpy as np
import pytest

from pidpanel.verification.response import CASES, layouts_rows, nafems_13r_rows


@pytest.mark.parametrize("name", ["miles", "power"])
def test_the_truths_of_the_page_are_met(tmp_path, name):
    rows = CASES[name](tmp_path)
    assert rows
    for row in rows:
        assert row.met, (row.quantity, row.computed, row.reference, row.error)


@pytest.mark.parametrize("name", ["one strong damper", "two that overlap, and a third"])
def test_dampers_on_modes_and_residual_vectors_are_those_on_all_elements(tmp_path, name):
    # the other layouts are in `make verification`
    for row in layouts_rows(tmp_path, [name]):
        assert row.met, (row.quantity, row.computed, row.reference, row.error)


def test_nafems_13r_is_met_and_its_stress_converges(tmp_path):
    # curvatures of quintic triangles converge at order 4; meshes are no halvings of one another,
    # so that a factor 4 for half the size is asked, and 12 found
    rows = list(nafems_13r_rows(tmp_path))
    for row in rows:
        assert row.met or not row.has_tolerance, (
            row.quantity,
            row.computed,
            row.reference,
            row.error,
        )
    stress = [row.error for row in rows if row.unit == "MPa2/Hz" and row.source == "sine series"]
    coarse, fine = np.abs(stress)
    assert fine < coarse / 4
