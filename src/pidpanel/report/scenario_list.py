"""Scenarios in few words, as sentences of the page name them."""

from __future__ import annotations

from collections.abc import Sequence

from pidpanel.report.answer import Candidate


def list_scenarios(candidates: Sequence[Candidate], among: Sequence[Candidate]) -> str:
    """Return scenarios in few words, the fills of one place and damper as one.

    Three fills of a place and more are written as a range, if no other of ``among`` lies in it.

    Examples
    --------
    >>> from pidpanel.report.names import FilledPatch, ReportedScenario
    >>> def candidate(patch, fill):
    ...     filling = FilledPatch(patch, fill_fraction=fill)
    ...     return Candidate(ReportedScenario(f"{patch}{fill}", (filling,)), 1.0, 1.0, {}, ())
    >>> some = [candidate(*c) for c in (("A", 0.7), ("A", 0.5), ("A", 0.9), ("B", 0.5))]
    >>> list_scenarios(some, some)
    'A at r = 0.5 to 0.9, B at r = 0.5'
    >>> list_scenarios(some, [*some, candidate("A", 0.6)])
    'A at r = 0.5, 0.7 and 0.9, B at r = 0.5'
    >>> list_scenarios([candidate("A", 0.5), candidate("B", 0.5)], some)
    'A and B at r = 0.5'
    """
    rivals = _fills([candidate for candidate in among if candidate not in candidates])
    by_fill: dict[str, list[str]] = {}
    for key, values in _fills(candidates).items():
        texts = [f"{value:g}" for value in sorted(values)]
        overlaps = any(min(values) < rival < max(values) for rival in rivals.get(key, []))
        if len(texts) > 2 and not overlaps:
            texts = [f"{texts[0]} to {texts[-1]}"]
        by_fill.setdefault(_listed(texts), []).append(key)
    return ", ".join(
        _listed(keys) + (f" at r = {fills}" if fills else "") for fills, keys in by_fill.items()
    )


def _listed(texts: Sequence[str]) -> str:
    """Return some texts with an "and" before the last."""
    *first, last = texts or [""]
    return f"{', '.join(first)} and {last}" if first else last


def _fills(candidates: Sequence[Candidate]) -> dict[str, list[float]]:
    """Return fills by place and damper; none for layouts and for dampers without a fill."""
    fills: dict[str, list[float]] = {}
    for candidate in candidates:
        fillings = candidate.scenario.fillings
        if len(fillings) == 1 and fillings[0].fill_fraction is not None:
            patch, *dampers = fillings[0].place
            key = patch + "".join(f" ({damper})" for damper in dampers)
            fills.setdefault(key, []).append(fillings[0].fill_fraction)
        else:
            fills.setdefault(candidate.scenario.label if len(fillings) > 1 else candidate.name, [])
    return fills
