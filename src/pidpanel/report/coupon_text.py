"""What came out of a coupon in plain figures."""

from __future__ import annotations

import pandas as pd

from pidpanel.report.inputs import CouponResults
from pidpanel.report.text import counted, number, percent, value_text


def coupon_text(results: CouponResults) -> str:
    """Return a coupon in words, which accuracy was asked for, and which was reached."""
    good = results.cases[results.cases["status"] == "ok"]
    text = f"{results.words} {results.accuracy}"
    if not len(good):
        return f"{text}; no case is ok."
    relative = (good["equivalent_damping_error_n_s_m3"] / good["equivalent_damping_n_s_m3"]).abs()
    return (
        f"{text}. Reached: {percent(relative.median(), 1)} in the median, "
        f"{percent(relative.max(), 1)} at most, in {len(good)} of "
        f"{counted(len(results.cases), 'case')}."
    )


def coupon_finding(cases: pd.DataFrame) -> str:
    """Return the range of C_e and where the particles dissipate most, with errors."""
    if not len(cases):
        return "No case is ok, so there is no result for this coupon."
    peak = cases.iloc[int(cases["loss_factor"].to_numpy().argmax())]
    low, high = cases["equivalent_damping_n_s_m3"].min(), cases["equivalent_damping_n_s_m3"].max()
    span = (
        f"{number(low)} to {number(high)} N s/m³"
        if len(cases) > 1
        else value_text(low, float(cases["equivalent_damping_error_n_s_m3"].iloc[0])) + " N s/m³"
    )
    return (
        f"C_e is {span}; the largest loss factor is "
        f"{value_text(peak['loss_factor'], peak['loss_factor_error'])} (the bound of an inelastic "
        f"bed is 1.27), at r = {peak['fill_fraction']:g}, {peak['frequency_hz']:g} Hz, "
        f"Γ = {peak['acceleration_g']:.4g}."
    )
