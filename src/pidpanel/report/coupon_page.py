"""The page of a study of the coupon alone: which parts it has, in which order."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from pidpanel.damping.surface_cases import COUNTED
from pidpanel.report import coupon_section
from pidpanel.report.coupon_figures import design_figure, loss_factor_map
from pidpanel.report.facts import cases_text, software_text
from pidpanel.report.films import film_picture
from pidpanel.report.html import CAVEATS, Block, Fragment, Page, figure_picture
from pidpanel.report.inputs import CouponResults
from pidpanel.report.measured_section import measured_section
from pidpanel.report.varied_section import findings, varied_section
from pidpanel.report.warnings import coupon_warnings


def coupon_page(
    title: str,
    assumptions: Sequence[str],
    stamp: Mapping[str, str],
    coupon: CouponResults,
    steps: Sequence[tuple[str, str]],
) -> Page:
    """Return the whole page."""
    good = coupon.cases[coupon.cases["status"].isin(COUNTED)]
    lost = coupon.cases[~coupon.cases["status"].isin(COUNTED)]
    keys = coupon.varied
    one_by_one = [] if coupon.is_design else keys
    results = findings(good, one_by_one)
    varied = varied_section(good, one_by_one) if one_by_one else None
    values: dict[str, Any] = {"design": None, "map": None}
    if coupon.is_design:
        values["design"] = figure_picture("loss_factor_design", design_figure, good, keys)
    elif varied is None and len(good[["frequency_hz", "acceleration_g"]].drop_duplicates()) > 1:
        values["map"] = figure_picture("loss_factor_map", loss_factor_map, good)
    values["text"] = coupon_section.coupon_text(coupon)
    first: list[Block] = [Fragment("coupon_first.html", values)]
    if varied is not None:
        first.append(varied)
    if coupon.shot is not None:
        first.append(film_picture(coupon.shot))
    warnings = coupon_warnings(coupon.cases)
    measured = [] if coupon.measured is None else [measured_section(coupon.measured)]
    sections = [coupon_section.coupon_section(replace(coupon, shot=None), varied=keys)]
    if not coupon.is_design:
        sections.append(coupon_section.losses_section(good))
    return Page(
        title=title,
        answer=results[0],
        first=first,
        caveats=warnings[:CAVEATS],
        facts=[("Coupon", cases_text(coupon.cases)), ("Software", software_text(stamp, dem=True))],
        assumptions=assumptions,
        summary=results[1:],
        warnings=[
            *warnings[CAVEATS:],
            *(f"{row['case']}: {row['status']}: {row['message']}" for _, row in lost.iterrows()),
        ],
        sections=[*measured, *(replace(section, folded=True) for section in sections)],
        steps=steps,
    )
