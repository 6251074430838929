"""Findings on the paper's claims, and their table on the page."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

from pidpanel.report.answer import SIGNIFICANCE
from pidpanel.report.html import Table
from pidpanel.report.text import READINGS


@dataclass(frozen=True)
class Finding:
    """Whether a claim holds, and the numbers behind it."""

    holds: bool | None  # None where the numbers do not decide
    evidence: str  # the numbers in words
    has_errors: bool = True  # whether the numbers have errors


@dataclass(frozen=True)
class Verdict:
    """The finding on a claim in one reading."""

    claim: str
    reading: str
    finding: Finding | None  # None where the claim cannot be tested
    reason: str = ""  # why it cannot be tested


def verdict_table(verdicts: Sequence[Verdict]) -> Table | None:
    """Return the claims, each once with all its readings, and the verdicts; None for none."""
    if not verdicts:
        return None
    rows = []
    for verdict in verdicts:
        if verdict.finding is None:
            answer, evidence = "cannot be tested", verdict.reason
        else:
            finding = verdict.finding
            undecided = "within the errors" if finding.has_errors else "no error, not judged"
            answers = {True: "holds", False: "does not hold", None: undecided}
            answer, evidence = answers[finding.holds], finding.evidence
        rows.append([verdict.claim, READINGS[verdict.reading], answer, evidence])
    claims = list(dict.fromkeys(verdict.claim for verdict in verdicts))
    rows.sort(key=lambda row: claims.index(row[0]))
    for previous, row in reversed(list(pairwise(rows))):
        row[0] = "" if row[0] == previous[0] else row[0]
    return Table(
        "The paper's claims tested against these results; decided where values differ by more "
        f"than {SIGNIFICANCE:g} standard errors",
        ["claim", "damping model", "verdict", "evidence (rms acceleration)"],
        rows,
    )
