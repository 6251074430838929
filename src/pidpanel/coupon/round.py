"""A round of tones: which cases were chosen, and what they reach.

What the response decides (`sampling.rounds`) and the coupon runs.
"""

from __future__ import annotations

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path


@dataclass(frozen=True)
class Round:
    """One round; the content of ``design/round<n>.json``.

    Attributes
    ----------
    cases
        Labels of all cases of the sweep chosen so far, those of this round last.
    new
        How many cases this round adds; none in the last.
    reached
        Whether all rms accelerations were accurate enough before this round.
    largest_relative_error, relative_error
        Stated before this round [1], None in round 0; by scenario and point.
    tones
        (r, f [Hz], Γ) of all cases beside the sweep chosen so far, those of this round last.
    """

    round: int
    cases: tuple[str, ...]
    new: int
    reached: bool = False
    largest_relative_error: float | None = None
    relative_error: dict[str, dict[str, float]] = field(default_factory=dict)
    tones: tuple[tuple[float, float, float], ...] = ()

    @property
    def count(self) -> int:
        """Number of all cases chosen so far."""
        return len(self.cases) + len(self.tones)

    @property
    def is_last(self) -> bool:
        """Whether it wants no more cases."""
        return self.new == 0

    def write(self, path: Path) -> None:
        """Write it as JSON."""
        path.write_text(json.dumps(asdict(self), indent=1), encoding="utf-8")

    @staticmethod
    def read(path: Path) -> Round:
        """Read what `write` left.

        Raises
        ------
        ValueError
            With the file, if it is no round.
        """
        try:
            values = json.loads(path.read_text(encoding="utf-8"))
            tones = tuple((r, f, gamma) for r, f, gamma in values["tones"])
            return Round(**{**values, "cases": tuple(values["cases"]), "tones": tones})
        except (KeyError, TypeError, ValueError) as error:
            raise ValueError(f"{path}: not a round of tones ({error})") from None


def read_rounds(folder: Path) -> tuple[Round, ...]:
    """Read the rounds in a folder up to the last."""
    rounds: list[Round] = []
    while not rounds or not rounds[-1].is_last:
        rounds.append(Round.read(folder / f"round{len(rounds)}.json"))
    return tuple(rounds)
