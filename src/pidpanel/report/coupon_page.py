"""The page of a study of the coupon alone: which parts it has, in which order."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from pidpanel.report.coupon_section import coupon_section
from pidpanel.report.facts import cases_text, software_text
from pidpanel.report.html import Page
from pidpanel.report.inputs import Coupon
from pidpanel.report.losses_section import losses_section
from pidpanel.report.varied_section import varied_findings, varied_keys, varied_section
from pidpanel.report.warnings import coupon_warnings
from pidpanel.study import CouponStudy


def coupon_page(
    study: CouponStudy, stamp: Mapping[str, str], coupon: Coupon, steps: Sequence[tuple[str, str]]
) -> Page:
    """Return the whole page; call it within `style.context`.

    Parameters
    ----------
    study, stamp
        The study and the stamp of its results.
    coupon
        What the coupon stage left.
    steps
        How to reproduce the results, as of `pidpanel.report.html.Page`.
    """
    good = coupon.cases[coupon.cases["status"] == "ok"]
    lost = coupon.cases[coupon.cases["status"] != "ok"]
    keys = varied_keys(study)
    sections = [varied_section(good, keys)] if keys else []
    sections += [coupon_section(coupon, varied=keys), losses_section(good)]
    damping = good["equivalent_damping_n_s_m3"]
    return Page(
        title=study.title or study.name,
        facts=[("Coupon", cases_text(coupon.cases)), ("Software", software_text(stamp))],
        assumptions=study.assumptions,
        summary=varied_findings(good, keys)
        or [f"C_e is {damping.min():.3g} to {damping.max():.3g} N s/m³ in these cases."],
        warnings=[
            *coupon_warnings(coupon.cases),
            *(f"{row['case']}: {row['status']}: {row['message']}" for _, row in lost.iterrows()),
        ],
        claims=None,
        sections=sections,
        steps=steps,
    )
