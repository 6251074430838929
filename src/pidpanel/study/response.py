"""The sections ``response`` and ``scenarios``: what is computed, and for which dampers."""

from __future__ import annotations

from typing import Any, Literal

from pydantic import model_validator

from pidpanel.study.base import Fill, Model, Positive, StudyError

Radiation = Literal["none", "one_side", "two_sides"]


class Response(Model):
    """The frequencies looked at, and what the patches do besides damping."""

    frequency_hz: tuple[Positive, Positive] = (20.0, 2000.0)
    damper_mass: bool = True
    modal_damping: Literal["full", "diagonal"] = "full"
    """full: the whole modal damping matrix; diagonal: the paper's Eq. 9–12."""
    radiation: Radiation = "none"
    """Sides of a baffled panel that radiate into the air and carry its mass; the paper has none."""
    radiation_beside: Radiation = "none"
    """Everything once more with this radiation, shown in a table beside."""
    maps: tuple[str, ...] = ()
    """Scenarios, by their names in summary.csv, to map over the panel; left out, the first bare."""

    @model_validator(mode="after")
    def _air(self) -> Response:
        if self.radiation_beside == self.radiation != "none":
            raise ValueError(
                f"radiation_beside = {self.radiation_beside}: another than radiation, or none"
            )
        if self.modal_damping == "diagonal" and {self.radiation, self.radiation_beside} != {"none"}:
            raise ValueError("modal_damping: diagonal is the paper's form: radiation must be none")
        return self

    @model_validator(mode="after")
    def _rises(self) -> Response:
        if self.frequency_hz[1] <= self.frequency_hz[0]:
            raise ValueError(
                f"frequency_hz = {list(self.frequency_hz)}: two values, the second above the first"
            )
        return self


class Family(Model):
    """One comparison: exactly one of patch, fill_fraction and oaspl_db is a list."""

    patch: str | tuple[str, ...]
    fill_fraction: Fill | tuple[Fill, ...]
    oaspl_db: float | tuple[float, ...] | None = None
    title: str = ""

    @model_validator(mode="after")
    def _one_list(self) -> Family:
        lists = [
            key
            for key in ("patch", "fill_fraction", "oaspl_db")
            if isinstance(getattr(self, key), tuple)
        ]
        if len(lists) != 1:
            raise ValueError(
                f"{len(lists)} of patch, fill_fraction and oaspl_db are lists: exactly one may be"
            )
        return self

    @property
    def varied(self) -> str:
        for key in ("patch", "fill_fraction", "oaspl_db"):
            if isinstance(getattr(self, key), tuple):
                return key
        raise StudyError("a family without a list")  # held off by the validator


class Scenario(Model):
    """One response: a patch with its fill (or none, the bare panel) at one level."""

    patch: str | None
    fill_fraction: float
    oaspl_db: float | None

    @property
    def label(self) -> str:
        level = "" if self.oaspl_db is None else f"_{self.oaspl_db:g}dB"
        if self.patch is None:
            return f"bare{level}"
        return f"{self.patch}_r{self.fill_fraction:g}{level}"

    @property
    def bare(self) -> Scenario:
        return Scenario(patch=None, fill_fraction=0.0, oaspl_db=self.oaspl_db)


def as_tuple(value: Any) -> tuple[Any, ...]:
    return tuple(value) if isinstance(value, tuple | list) else (value,)
