"""The answer after tests that have been made: ranges, shares of what remains, what has changed."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from pidpanel.arrays import Array
from pidpanel.constants import IMPROBABLE
from pidpanel.margin.assessment import LEVELS, PointAnswer
from pidpanel.margin.next_test import ScoreDistribution, posterior, remaining
from pidpanel.margin.update.posterior import DRAWN, Emulator, Result

EXACT = 1e-6  # variance of a score that becomes known


@dataclass(frozen=True)
class Updated:
    """What tests tell."""

    stated: Array  # (n, n_scores) samples of the scores before the tests
    scores: Array  # (n, n_scores) after them
    effective: float  # samples that weigh, over all
    tests: list[dict[str, Any]]  # a row for each measured value

    @classmethod
    def by(cls, scores: Array, results: Sequence[Result], damping: Sequence[slice]) -> Updated:
        """Return the update by results that agree with the stated spreads.

        Parameters
        ----------
        scores
            (n_runs, n_scores) of the runs.
        damping
            Scores of the errors of damping models.
        """
        stated = np.random.default_rng(5).standard_normal((DRAWN, scores.shape[1]))
        rows: list[dict[str, Any]] = []
        used = []
        for result in results:
            emulator = Emulator(scores, [result], damping)
            probability, score = emulator.probability()
            if probability >= IMPROBABLE:
                used.append(result._replace(chaoses=emulator.chaoses[0]))
            rows += [
                {"test": result.name, "quantity": name, "score": value, "probability": probability}
                for name, value in zip(result.channels, score.tolist(), strict=True)
            ]
        if not used:
            rows = [{**row, "probability_together": 1.0} for row in rows]
            return cls(stated, stated, 1.0, rows)
        emulator = Emulator(scores, used, damping)
        together = emulator.probability()[0]
        rows = [{**row, "probability_together": together} for row in rows]
        return cls(stated, *emulator.posterior(), rows)

    @property
    def normal(self) -> ScoreDistribution:
        """The normal distribution with the mean and covariance of the scores."""
        return ScoreDistribution(self.scores.mean(axis=0), np.cov(self.scores, rowvar=False))

    def drawn(self, answer: PointAnswer) -> Array:
        """Return samples of an answer [g], with what its chaos misses in runs left out."""
        missed = np.random.default_rng(4).choice(answer.chaos.missed, len(self.scores))
        return np.asarray(answer.chaos(self.scores) * np.exp(missed))

    def share_rows(
        self, answer: PointAnswer, names: Sequence[str], sources: Sequence[str],
        groups: Sequence[slice],
    ) -> list[dict[str, Any]]:  # fmt: skip
        """Return the shares of the inputs in the variance that is left.

        ``share_alone`` would go if this input became known, ``share`` remains when all others are:
        after a test inputs depend on each other.
        """
        normal, unit = self.normal, np.eye(self.scores.shape[1])
        rows = []
        for name, source, part in zip(names, sources, groups, strict=True):
            left = []
            for selector in (unit[part], np.delete(unit, part, axis=0)):
                error = EXACT * np.eye(len(selector))
                covariance = posterior(selector, error, normal.covariance)
                left.append(remaining(answer.chaos, covariance, normal)[0])
            rows.append({**answer.place, "input": name, "share_alone": 1 - left[0],
                         "share": left[1], "source": source})  # fmt: skip
        return sorted(rows, key=lambda row: -row["share_alone"])


def input_rows(keys: Sequence[str], stated: Array, updated: Array) -> list[dict[str, Any]]:
    """Return 5, 50 and 95 % of inputs (n, n_keys) before and after the tests."""
    columns = [f"{when}_p{level:02.0f}" for when in ("stated", "updated")
               for level in 100 * np.array(LEVELS)]  # fmt: skip
    values = np.vstack([np.quantile(part, LEVELS, axis=0) for part in (stated, updated)])
    return [
        {"input": key, **dict(zip(columns, column, strict=True))}
        for key, column in zip(keys, values.T.tolist(), strict=True)
    ]
