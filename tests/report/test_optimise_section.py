"""What the page says of the search for layouts."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.report.inputs import ProposalResults
from pidpanel.report.optimise_section import (
    gap_text,
    proposal_headline,
)


def proposal(gap, violations, names=("base",)):
    """The best layout of a search with a gap [dB]."""
    layouts = pd.DataFrame(
        {
            "layout": [1], "centre_x_m": [0.5], "centre_y_m": [0.3], "size_x_m": [0.2],
            "size_y_m": [0.2], "patch": [np.nan], "damper": ["acrylic"], "fill_fraction": [0.9], "mass_kg": [0.5],
        }
    )  # fmt: skip
    best = {"patches": 1, "mass_kg": 0.5, "reduction_db": 9.7, "reduction_error_db": 2.2}
    best |= {"excitation": "base", "sound_reduction_db": 11.2, "base_reduction_db": 9.7}
    front = pd.DataFrame([{"layout": 1, **best, "search_reduction_db": 9.8}])
    rms = {"bare_rms_g": 130.0, "acceleration_rms_g": 43.0, "acceleration_rms_error_g": 11.0}
    summary = pd.DataFrame(
        [{"layout": 1, "excitation": name, "point": "tip", "counts": True, **rms} for name in names]
    )
    search = pd.Series(
        {
            "budget_kg": 2.0, "gap_db": gap + 0.2, "drift_db": 0.1, "nodes": 200.0, "evaluated_layouts": 25041.0,
            "submodularity_checks": 6864.0, "submodularity_violations": violations,
            "bound_factor": 1.13, "bound_excess": 0.021, "is_exhaustive": 0.0,
        }
    )  # fmt: skip
    return ProposalResults(layouts, front, summary, pd.DataFrame(), search=search)


def test_a_search_without_a_bound_says_why_and_what_it_tried():
    unbound = proposal(np.inf, 796.0)
    text, headline = gap_text(unbound), proposal_headline(unbound)
    assert "reductions of single dampers add up to more than the whole response" in text
    assert "25 041 layouts" in text and "796 of 6 864" in text and "1.13" not in text
    assert headline.endswith("the best of 25 041 layouts tried, not proved to be the best of all.")
    assert "inf" not in text + headline


@pytest.mark.parametrize(
    ("violations", "message"), [(0.0, "holds in all of 6 864"), (3.0, "fails in 3 of 6 864")]
)
def test_a_gap_is_proved_where_no_check_fails(violations, message):
    bound = proposal(0.31, violations)
    assert "leaves 0.31 dB" in gap_text(bound) and message in gap_text(bound)
    # with twice the 0.1 dB between search and consistent motion, rounded up
    assert ("Not proved" in proposal_headline(bound)) == bool(violations)
    assert "0.55 dB" in proposal_headline(bound)
    assert ("2.1 % of the bare mean square" in gap_text(bound)) == bool(violations)


def test_where_every_layout_was_evaluated_no_property_is_needed():
    every = proposal(0.0, 796.0)
    # twice the drift alone
    every.search["is_exhaustive"] = 1.0
    message = "Every layout was evaluated: no layout here is better by more than 0.2 dB"
    assert message in proposal_headline(every)
    assert "Every layout" in gap_text(every) and "fails" not in gap_text(every)
