"""The main results of a study in sentences."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from itertools import product

import numpy as np
import pandas as pd

from pidpanel.report.rms import moving_points, rms_by
from pidpanel.report.text import READINGS
from pidpanel.response.bands import reduction
from pidpanel.study import Study


def outcome(study: Study, summary: pd.DataFrame) -> list[str]:
    """Return the main results, one sentence for each family and reading.

    Parameters
    ----------
    study
        The study.
    summary
        ``response/summary.csv`` (points as text).

    Notes
    -----
    A family without a steady response in a reading is left out; the warnings name it.
    """
    sentences = []
    points = moving_points(summary, list(study.panel.points))
    for reading, family in product(study.readings, study.families):
        scenarios = study.family_scenarios(family)
        varied = study.families[family].varied
        labels: dict[object, str] = {getattr(s, varied): s.label for s in scenarios}
        bare_labels = {getattr(s, varied): s.bare.label for s in scenarios}
        rms = rms_by(summary, reading, labels, points)
        bare = rms_by(summary, reading, bare_labels, points)
        gained = pd.DataFrame(reduction(bare, rms), rms.index, rms.columns)
        if not np.isfinite(gained.to_numpy()).all():
            continue
        if varied == "oaspl_db":
            gained = gained.sort_index()
            low, high = gained.index[0], gained.index[-1]
            said = f"under {low:g} and {high:g} dB the damper lowers the rms acceleration by " + (
                ", ".join(
                    f"{gained[p].iloc[0]:.1f} and {gained[p].iloc[-1]:.1f} dB at point {p}"
                    for p in points
                )
            )
        else:
            what, name = ("fill", "r = ") if varied == "fill_fraction" else ("location", "")
            said = f"the best {what} is " + ", ".join(
                f"{name}{gained[p].idxmax()} at point {p} ({gained[p].max():.1f} dB below the bare "
                f"panel, {rms[p].min():.3g} g rms)"
                for p in points
            )
        sentences.append(f"{READINGS[reading]}: {said}.")
    for reading in study.readings:
        sentences += _best_layouts(study, summary, reading, points)
    return sentences


def _best_layouts(
    study: Study, summary: pd.DataFrame, reading: str, points: Sequence[str]
) -> Iterator[str]:
    """Yield the best layout at each point, beside the same mass as dead weight."""
    of = summary[(summary["reading"] == reading) & summary["scenario"].isin(list(study.layouts))]
    of = of[of["status"] == "ok"]
    said = []
    for point in points if len(of) else ():
        best = of[of["point"] == point].sort_values("reduction_db").iloc[-1]
        beside = ""
        if np.isfinite(best["dead_weight_reduction_db"]):
            beside = (
                f", the same {best['added_mass_kg']:.3g} kg as dead weight "
                f"{best['dead_weight_reduction_db']:.1f} dB"
            )
        said.append(
            f"at point {point} {best['scenario']} ({best['reduction_db']:.1f} dB below the bare "
            f"panel, {best['acceleration_rms_g']:.3g} g rms{beside})"
        )
    if said:
        yield f"{READINGS[reading]}: the best layout is, {'; '.join(said)}."
