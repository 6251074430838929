"""The energy of the coupon on the page: where it goes, and how well its balance closes."""

from __future__ import annotations

import pandas as pd

from pidpanel.coupon.window import CLOSURE_LIMIT
from pidpanel.report import style
from pidpanel.report.coupon_figures import losses_figure
from pidpanel.report.html import PageSection, Paragraph, Picture
from pidpanel.report.text import percent


def losses_section(cases: pd.DataFrame) -> PageSection:
    """Return shares of the losses and errors of the energy balance."""
    closure = cases["closure"].dropna().abs()
    if closure.empty:
        text = "No run listed its contacts, so the energy balance is unknown."
        return PageSection("losses", "Energy balance of the coupon", [Paragraph(text)])
    caption = (
        "Left: share of the losses in the normal direction of the contacts (damping of the Hertz "
        "contact); the rest is friction, the second integral of the paper's Eq. 3. Right: error of "
        "the balance work = losses + change of kinetic, elastic and potential energy, the worst "
        f"seed of each case: median {percent(closure.median(), 2)}, largest "
        f"{percent(closure.max(), 2)}. Grey: the {percent(CLOSURE_LIMIT)} within which a run is "
        "accepted. LIGGGHTS lists contact forces with the velocity at the end of a time step, so "
        "about 1 % is missing at a fifth of the Rayleigh time, and less with shorter steps."
    )
    picture = Picture("losses", style.png(losses_figure(cases)), caption)
    return PageSection("losses", "Energy balance of the coupon", [picture])
