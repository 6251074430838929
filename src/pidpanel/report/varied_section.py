"""What a study of a coupon varies on the page: how much C_e depends on each key."""

from collections.abc import Sequence
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.report.coupon_figures import EQUIVALENT_DAMPING, varied_figure
from pidpanel.report.html import Fragment, figure_picture
from pidpanel.report.templates import lines
from pidpanel.report.text import NAMES
from pidpanel.response.trust import SIGNIFICANCE

LABELS: dict[str, str] = NAMES["varied"]

VALUE, ERROR = EQUIVALENT_DAMPING.column, EQUIVALENT_DAMPING.error


def varied_section(cases: pd.DataFrame, keys: Sequence[str]) -> Fragment:
    """Return C_e over each of the keys."""
    values = [
        {
            "name": _name(key),
            "others": ", ".join(_name(name) for name in keys if name != key),
            "picture": figure_picture(
                f"over_{key.replace('.', '_')}", varied_figure, cases, key, LABELS.get(key, key)
            ),
        }
        for key in keys
    ]
    return Fragment("varied.html", {"keys": values})


def findings(cases: pd.DataFrame, keys: Sequence[str]) -> list[str]:
    """Return the main results: a sentence for each key, or the range of C_e and the peak of η."""
    values: dict[str, Any] = {"findings": [], "peak": None, "count": len(cases)}
    for key in keys:
        changes = comparison(cases, key)
        if changes.empty:
            continue
        largest = dict(changes.iloc[int(np.log(changes["ratio"]).abs().argmax())])
        far = int((changes["deviation"].abs() > SIGNIFICANCE).sum())
        ends = {name: _text(largest[name]) for name in ("from", "to")}
        about = {"name": _name(key), "far": far, "count": len(changes)}
        values["findings"].append({**largest, **ends, **about})
    if len(cases):
        values["peak"] = cases.iloc[int(cases["loss_factor"].to_numpy().argmax())]
        values |= {"low": cases[VALUE].min(), "high": cases[VALUE].max()}
        values["error"] = float(cases[ERROR].iloc[0])
    return lines("coupon_findings.html", values)


def comparison(cases: pd.DataFrame, key: str) -> pd.DataFrame:
    """Compare every case with the one at the first value of a key, all else equal.

    A row for each case but the first of its group: C_e of both, the ratio, and the difference over
    its standard error, ``deviation``.

    The bias of softened contacts is common to both and drops out of the difference, unless the
    moduli differ.
    """
    same = ["fill_fraction", "frequency_hz", "acceleration_g"]
    statistical = "statistical_error_n_s_m3"
    firsts = cases.drop_duplicates(same)
    pairs = cases.drop(index=firsts.index).merge(firsts, on=same, suffixes=("", "_first"))
    pairs = pairs.sort_values(same, kind="stable")
    equal = pairs["youngs_modulus_mpa"] == pairs["youngs_modulus_mpa_first"]
    errors = [np.hypot(pairs[name], pairs[f"{name}_first"]) for name in (statistical, ERROR)]
    names = {f"{key}_first": "from", key: "to", f"{VALUE}_first": "first", VALUE: "last",
             f"{ERROR}_first": "first_error", ERROR: "last_error"}  # fmt: skip
    changes = pairs[[*same, *names]].rename(columns=names)
    error = pd.Series(np.where(equal, errors[0], errors[1]), changes.index)
    deviation = (changes["last"] - changes["first"]) / error
    return changes.assign(ratio=changes["last"] / changes["first"], deviation=deviation)


def _name(key: str) -> str:
    return LABELS.get(key, key).rpartition(", ")[0] or LABELS.get(key, key)


def _text(value: object) -> str:
    return f"{value:g}" if isinstance(value, float) else str(value)
