"""Ranges, probabilities, margins of safety and shares of variance of answers, from their chaos."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any, NamedTuple

import numpy as np

from pidpanel.arrays import Array
from pidpanel.margin.chaos import Chaos

ENOUGH = 0.98  # of Q²: the surrogate stands for the runs
DRAWN = 16384  # samples of the surrogate
LEVELS = (0.05, 0.5, 0.95)


class PointAnswer(NamedTuple):
    """g rms at a point, with a limit or NaN."""

    scenario: str
    point: str
    panel: str  # "bare" or "damped"
    nominal: float
    values: Array  # (n_runs,) [g]
    limit: float
    chaos: Chaos

    @property
    def place(self) -> dict[str, str]:
        """Columns that name it."""
        return {"scenario": self.scenario, "point": self.point, "panel": self.panel}

    def drawn(self, size: int) -> Array:
        """Return samples of the surrogate [g]; of the runs where it does not stand for them."""
        if self.chaos.q2 < ENOUGH:
            return self.values
        z = np.random.default_rng(0).standard_normal((DRAWN, size))
        return self.chaos(z)


def range_row(answer: PointAnswer, drawn: Array, factor_of_safety: float) -> dict[str, Any]:
    """Return the range of samples of an answer, the probability to exceed its limit, margins.

    The margin of safety is limit/(FoS · σ) − 1, which for an allowable of three times the limit is
    allowable/(FoS · 3σ) − 1, with σ the g rms that 50 % or 95 % of the samples do not exceed.
    """
    limit = answer.limit
    low, middle, high = np.quantile(drawn, LEVELS)
    has_limit = np.isfinite(limit)
    return {
        **answer.place,
        "nominal_g": answer.nominal,
        "p05_g": low,
        "p50_g": middle,
        "p95_g": high,
        "limit_g": limit,
        "samples": drawn.size,
        "probability_exceeding": float(np.mean(drawn > limit)) if has_limit else np.nan,
        "margin_of_safety_p50": limit / (factor_of_safety * middle) - 1,
        "margin_of_safety_p95": limit / (factor_of_safety * high) - 1,
        "q2": answer.chaos.q2,
    }


def share_rows(
    answer: PointAnswer, names: Sequence[str], sources: Sequence[str], groups: Sequence[slice]
) -> Iterator[dict[str, Any]]:
    """Yield the shares of the groups of inputs in the variance of an answer, the largest first."""
    first, total = answer.chaos.shares(groups)
    for number in np.argsort(total)[::-1].tolist():
        yield {
            **answer.place, "input": names[number], "share_alone": first[number],
            "share": total[number], "source": sources[number],
        }  # fmt: skip


def governing(
    answers: Sequence[PointAnswer], size: int, layout_of: Mapping[str, str]
) -> PointAnswer:
    """Return the worst point and level of the best layout, by the 95 % over the limit.

    Points without a limit count only where none has one. ``layout_of`` has the layouts of
    scenarios.
    """

    def load(answer: PointAnswer) -> float:
        high = float(np.quantile(answer.drawn(size), LEVELS[-1]))
        return high / answer.limit if np.isfinite(answer.limit) else high * 1e-6

    worst: dict[str, PointAnswer] = {}
    for answer in answers:
        if answer.panel == "damped":
            layout = layout_of[answer.scenario]
            worst[layout] = max(worst.get(layout, answer), answer, key=load)
    return min(worst.values(), key=load)
