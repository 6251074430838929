"""The sections ``response`` and ``scenarios``: what is computed, and for which dampers."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal

from pidpanel.study.base import Fill, Model, Positive
from pidpanel.study.mistakes import Mistake

Radiation = Literal["none", "one_side", "two_sides"]
Varied = Literal["patch", "fill_fraction", "oaspl_db"]


class Response(Model):
    """The frequencies of the response, and what is part of the panel's equation of motion."""

    frequency_hz: tuple[Positive, Positive] = (20.0, 2000.0)
    """Lowest and highest frequency [Hz]."""
    damper_mass: bool = True
    """Whether the apparent mass of the particles is added to the panel."""
    modal_damping: Literal["full", "diagonal"] = "full"
    """full: the whole modal damping matrix; diagonal: the paper's Eq. 9–12."""
    radiation: Radiation = "none"
    """Sides of a baffled panel that radiate into the air and carry its mass; none in the paper."""
    radiation_beside: Radiation = "none"
    """Radiation of a second computation, shown in a table beside the first."""
    maps: tuple[str, ...] = ()
    """Scenarios, by their names in summary.csv, to map over the panel; by default the first bare
    panel."""

    def mistakes(self) -> Iterator[Mistake]:
        """Yield frequencies that do not increase, and kinds of radiation that do not combine."""
        if self.frequency_hz[1] <= self.frequency_hz[0]:
            yield Mistake(("frequency_hz",), "must be two values, the second above the first")
        if self.radiation_beside == self.radiation != "none":
            yield Mistake(("radiation_beside",), "must differ from radiation, or be none")
        if self.modal_damping == "diagonal":
            for key in ("radiation", "radiation_beside"):
                if getattr(self, key) != "none":
                    yield Mistake(
                        (key,), "must be none for modal_damping: diagonal, the paper's form"
                    )


class Family(Model):
    """One comparison: exactly one of patch, fill_fraction and oaspl_db is a list."""

    patch: str | tuple[str, ...]
    fill_fraction: Fill | tuple[Fill, ...]
    oaspl_db: float | tuple[float, ...] | None = None
    """Overall sound pressure level [dB]; by default that of the section ``sound``."""
    title: str = ""

    def mistakes(self) -> Iterator[Mistake]:
        """Yield a comparison of nothing, or of more than one thing."""
        for key in self._lists():
            if not getattr(self, key):
                yield Mistake((key,), "must have at least 1 value(s), not 0")
        lists = len(self._lists())
        if lists != 1:
            yield Mistake(
                (),
                "exactly one of patch, fill_fraction and oaspl_db must be a list, "
                + (f"not {lists}" if lists else "not none"),
            )

    @property
    def varied(self) -> Varied:
        """The key that is a list."""
        return self._lists()[0]

    def _lists(self) -> list[Varied]:
        keys: tuple[Varied, ...] = ("patch", "fill_fraction", "oaspl_db")
        return [key for key in keys if isinstance(getattr(self, key), tuple)]


class Scenario(Model):
    """One response: a patch with its fill, or the bare panel, at one level.

    Attributes
    ----------
    patch : str or None
        Name of the patch that is filled; None for the bare panel.
    fill_fraction : float
        Fill of the patch; 0 for the bare panel.
    oaspl_db : float or None
        Overall sound pressure level [dB]; None for that of the spectrum's table.
    """

    patch: str | None
    fill_fraction: float
    oaspl_db: float | None

    @property
    def label(self) -> str:
        """Name of the scenario in tables and files, such as ``PID-1_r0.5_162dB``."""
        level = "" if self.oaspl_db is None else f"_{self.oaspl_db:g}dB"
        if self.patch is None:
            return f"bare{level}"
        return f"{self.patch}_r{self.fill_fraction:g}{level}"

    @property
    def bare(self) -> Scenario:
        """The bare panel at the same level."""
        return Scenario(patch=None, fill_fraction=0.0, oaspl_db=self.oaspl_db)
