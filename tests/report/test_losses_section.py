"""Where the energy of the coupon goes."""

import numpy as np

from pidpanel.report.coupon_figures import losses_figure
from pidpanel.report.coupon_section import losses_section
from tests.page_reader import blocks_of


def test_losses_are_shown_in_percent_of_what_they_are_a_share_of(cases):
    left, right = losses_figure(cases).axes
    assert {y for line in left.lines for y in line.get_ydata()} == {45.0}
    assert {y for line in right.lines for y in line.get_ydata()} == {-1.0, 0.0}


def test_runs_that_list_no_contacts_have_no_figure(cases):
    (block,) = blocks_of(losses_section(cases.assign(closure=np.nan)))
    assert block.kind == "paragraph"
    assert "is unknown" in block.text
