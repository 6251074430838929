"""Scenarios as a reader knows them: in every sentence, table and legend of a page the same."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import pandas as pd

from pidpanel.paths import SECTION


@dataclass(frozen=True)
class FilledPatch:
    """A patch and its damper."""

    patch: str
    damper: str | None = None
    fill_fraction: float | None = None

    @property
    def place(self) -> tuple[str, ...]:
        """The patch, and the damper where it has a name of its own."""
        return (self.patch,) if self.damper in (None, SECTION) else (self.patch, str(self.damper))


@dataclass(frozen=True)
class ReportedScenario:
    """A scenario of a page."""

    label: str  # in the files of results
    fillings: tuple[FilledPatch, ...] = ()
    oaspl_db: float | None = None  # None for the level of the spectrum's table
    bare_label: str = ""  # of the bare panel under the same sound

    @property
    def is_bare(self) -> bool:
        """Whether no patch is filled."""
        return not self.fillings

    @property
    def patch(self) -> str:
        """Names of the filled patches."""
        return "+".join(filling.patch for filling in self.fillings)

    @property
    def fill_fraction(self) -> float:
        """The fill of the only patch; NaN without one."""
        fills = [filling.fill_fraction for filling in self.fillings]
        return fills[0] if len(fills) == 1 and fills[0] is not None else math.nan

    @property
    def layout_label(self) -> str:
        """Its label without the sound level."""
        level = self.oaspl_db
        return self.label if level is None else self.label.removesuffix(f"_{level:g}dB")

    @property
    def name(self) -> str:
        """The scenario without its sound level as a reader knows it.

        Examples
        --------
        >>> ReportedScenario("PID-1_r0.5", (FilledPatch("PID-1", fill_fraction=0.5),)).name
        'PID-1, r = 0.5'
        """
        if self.is_bare:
            return "bare panel"
        text = self.filling_text
        return text if len(self.fillings) == 1 else f"{self.label} ({text})"

    @property
    def filling_text(self) -> str:
        """The filled patches with dampers and fills."""
        parts = []
        for filling in self.fillings:
            fill = [] if filling.fill_fraction is None else [f"r = {filling.fill_fraction:g}"]
            parts.append(", ".join([*filling.place, *fill]))
        return "; ".join(parts)


def with_names(frame: pd.DataFrame, names: Mapping[str, str]) -> pd.DataFrame:
    """Return a table of results with the names of its scenarios in place of their labels."""
    return frame.assign(scenario=[names.get(label, label) for label in frame["scenario"]])
