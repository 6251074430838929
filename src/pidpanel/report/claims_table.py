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
    """Whether a claim holds, and the numbers behind it.

    Attributes
    ----------
    holds
        The verdict; None where the numbers do not decide.
    evidence
        The numbers in words.
    has_errors
        Whether the numbers have errors.
    """

    holds: bool | None
    evidence: str
    has_errors: bool = True


@dataclass(frozen=True)
class Verdict:
    """The finding on a claim in one reading.

    Attributes
    ----------
    claim
        The claim in words.
    reading
        Reading of the damping, such as ``dem``.
    finding
        None where the claim cannot be tested.
    reason
        Why it cannot be tested.
    """

    claim: str
    reading: str
    finding: Finding | None
    reason: str = ""


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
