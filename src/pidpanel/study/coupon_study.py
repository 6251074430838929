"""A study of coupons alone."""

from __future__ import annotations

import itertools
import math
import re
from collections.abc import Iterator, Mapping, Sequence
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError, ValidationInfo, field_validator, model_validator

from pidpanel.columns import ColumnsError, LineFaults
from pidpanel.paths import SECTION, TEMPLATES
from pidpanel.study.base import SectionModel, Text, file_in, found_file
from pidpanel.study.coupon import Coupon
from pidpanel.study.mistakes import (
    LONGEST_NAME,
    Mistake,
    Mistakes,
    dotted,
    is_formula,
    mistakes_of,
    unknown_key,
)
from pidpanel.study.sweep import CaseRow, read_cases, sweep_of

NAME = "[A-Za-z0-9][A-Za-z0-9_-]*"
# Of dampers; also of wildcards, in which Snakemake allows no braces.
DAMPER_NAME = "[A-Za-z0-9](?:[A-Za-z0-9_ -]*[A-Za-z0-9_-])?"
CHARACTERS = f"up to {LONGEST_NAME} letters a to z or A to Z, digits, '_' and '-'"
RESERVED = ("coupon",)  # folders of the results that belong to all studies

MOST_VARIANTS = 1000  # combinations that ``vary`` may have
DRIVE = ("fill_fraction", "frequency_hz", "acceleration_g", "displacement_mm")  # of a row of cases


def mistakes_of_name(name: str) -> Iterator[Mistake]:
    """Yield what is wrong with the name of a study."""
    if len(name) > LONGEST_NAME or not re.fullmatch(NAME, name):
        yield Mistake(("name",), f"must be {CHARACTERS}, the first a letter or a digit")
    elif name in RESERVED:
        message = f"must be another name; results/{name} is shared by all studies"
        yield Mistake(("name",), message)


class VariedCoupon(Coupon):
    """A coupon of a study of it alone: any of its keys may be varied."""

    vary: Mapping[str, Annotated[tuple[Any, ...], Field(min_length=1)]] = {}
    """Values of any other key of the coupon, such as ``particles.friction: [0.1, 0.3, 0.6]``. The
    whole sweep is run for each value, and for every combination of several keys."""
    cases: Path | None = None
    """CSV table of cases instead of ``sweep`` and ``vary``, such as a design of experiments. A row
    is a case, a column a key of the coupon such as ``sweep.fill_fraction``, ``sweep.frequency_hz``,
    ``sweep.acceleration_g``, ``particles.friction`` or ``cell.depth_mm``."""
    measured: Annotated[Path, file_in()] | None = None
    """CSV table of measured C_e and m_a of these particles in this cell, with the columns of a
    [table of damping](../tables.md#tables) and an amplitude in each row. The report compares them
    with the simulated cases and the atlas; with ``vary`` it names the values that differ least."""

    @model_validator(mode="before")
    @classmethod
    def _sweep_of_cases(cls, values: Any, info: ValidationInfo) -> Any:
        """Give a coupon with a table of cases the sweep of all its rows."""
        if not isinstance(values, Mapping) or values.get("cases") is None:
            return values
        if extra := [key for key in ("sweep", "vary") if key in values]:
            raise Mistakes(Mistake((key,), "not allowed together with cases") for key in extra)
        if not isinstance(values["cases"], str | Path):
            raise Mistakes([Mistake(("cases",), "must be a path")])
        folder = (info.context or {}).get("folder", Path())
        try:
            file = found_file(Path(values["cases"]), folder, None)
            return {**values, "cases": file, "sweep": sweep_of(read_cases(file))}
        except ColumnsError as error:
            raise Mistakes(Mistake(("cases",), fault) for fault in error.faults) from None
        except ValueError as error:
            raise Mistakes([Mistake(("cases",), str(error))]) from None

    @cached_property
    def rows(self) -> list[CaseRow]:
        """Rows of the table of cases; none without one."""
        return [] if self.cases is None else read_cases(self.cases)

    @property
    def varied_values(self) -> Mapping[str, tuple[Any, ...]]:
        """Values of each key of ``vary``, or of each in the table of cases besides the drive."""
        if not self.rows:
            return self.vary
        inputs = [row.inputs for row in self.rows]
        return {key: tuple(dict.fromkeys(row[key] for row in inputs)) for key in inputs[0]}

    @property
    def decks(self) -> tuple[Path, ...]:
        """All deck templates instead of ``templates/shake.in.j2``."""
        return (*super().decks, *(deck for deck in self.vary.get("deck", ()) if deck is not None))

    @field_validator("vary")
    @classmethod
    def _find_decks(
        cls, vary: Mapping[str, tuple[Any, ...]], info: ValidationInfo
    ) -> Mapping[str, tuple[Any, ...]]:
        folder = (info.context or {}).get("folder")
        if folder is None or "deck" not in vary:
            return vary
        decks: list[Path | None] = []
        for index, name in enumerate(vary["deck"]):
            try:
                decks.append(name and found_file(Path(name), folder, TEMPLATES))
            except ValueError as error:
                raise Mistakes([Mistake(("deck", index), str(error))]) from None
        return {**vary, "deck": tuple(decks)}

    def _mistakes_of_runs(self) -> Iterator[Mistake]:
        if self.measured is not None and (self.cases or len(self.diameters) > 1):
            message = "not allowed together with cases or several diameters"
            yield Mistake(("measured",), message)
        if self.cases is not None:
            yield from self._mistakes_of_cases(self.cases)
            return
        yield from self._mistakes_of_sizes()
        count = math.prod(len(values) for values in self.vary.values())
        if count > MOST_VARIANTS:
            yield Mistake(("vary",), f"{count} combinations; allowed are {MOST_VARIANTS}")
            return
        yield from self._mistakes_of_variants()
        yield from self._mistakes_of_amount(count)

    def _mistakes_of_variants(self) -> Iterator[Mistake]:
        allowed = list(_dotted_keys(self._values()))
        for key, values in self.vary.items():
            if key not in allowed:
                yield Mistake(("vary", key), _unknown_in(key, allowed))
            for index, value in enumerate(values):
                if value in values[:index]:
                    yield Mistake(("vary", key, index), "duplicate value")
        # a mistake of many combinations is reported for the first
        combinations: dict[Mistake, Mapping[str, Any]] = {}
        for chosen in self._combinations() if self.vary and set(self.vary) <= set(allowed) else ():
            try:
                self._variant(chosen)
            except ValidationError as error:
                for mistake in mistakes_of(error, Coupon):
                    combinations.setdefault(mistake, chosen)
        yield from (self._in_vary(mistake, chosen) for mistake, chosen in combinations.items())

    def _mistakes_of_cases(self, file: Path) -> Iterator[Mistake]:
        """Yield columns that are no keys, and rows that are no coupon."""
        allowed = [key for key in _dotted_keys(self._row_values(), leaves=True) if key != "deck"]
        unknown = [key for key in self.rows[0].values if key not in allowed]
        for key in unknown:
            yield Mistake(("cases",), f"column {key}: {_unknown_in(key, allowed)}")
        if unknown:
            return
        wrong = LineFaults(file)
        for line, values in self.rows:
            try:
                self._variant(values)
            except ValidationError as error:
                for keys, message, _ in mistakes_of(error, Coupon):
                    key = dotted(tuple(part for part in keys if isinstance(part, str)))
                    setting = f"{key} = {values[key]}" if key in values else key
                    wrong.add(line, f"{setting}: {message}", f"{key}: {message.partition(';')[0]}")
        for fault in ColumnsError(wrong.texts()).faults:
            yield Mistake(("cases",), fault)

    def _in_vary(self, mistake: Mistake, chosen: Mapping[str, Any]) -> Mistake:
        """Return the mistake of a variant at the value of ``vary`` that causes it."""
        for key, value in chosen.items():
            path = tuple(key.split("."))
            if mistake.keys[: len(path)] == path:
                index = self.vary[key].index(value)
                return Mistake(("vary", key, index, *mistake.keys[len(path) :]), mistake.message)
        values = ", ".join(f"{name} = {value}" for name, value in chosen.items())
        return Mistake(("vary",), f"with {values}: {dotted(mistake.keys)}: {mistake.message}")

    def variants(self) -> tuple[tuple[Mapping[str, Any], Coupon], ...]:
        """Return every combination of ``vary``, or row of ``cases``, and the coupon that it means.

        Returns
        -------
        tuple of (dict, Coupon)
            Varied keys with their values, without those of the drive and the accuracy of a row,
            and the coupon with all of them; without any no keys and the coupon itself.
        """
        if self.rows:
            return tuple((row.inputs, self._variant(row.values)) for row in self.rows)
        if not self.vary:
            return (({}, self),)
        return tuple((chosen, self._variant(chosen)) for chosen in self._combinations())

    def _combinations(self) -> Iterator[dict[str, Any]]:
        for values in itertools.product(*self.vary.values()):
            yield dict(zip(self.vary, values, strict=True))

    def _variant(self, chosen: Mapping[str, Any]) -> Coupon:
        values = self._values() if self.cases is None else self._row_values()
        for key, value in chosen.items():
            *path, last = key.split(".")
            section = values
            for part in path:
                section = section[part]
            is_single = isinstance(section[last], tuple) and not isinstance(value, tuple | list)
            section[last] = (value,) if is_single and self.cases is not None else value
        return Coupon.model_validate({"sweep": self.sweep, "accuracy": self.accuracy, **values})

    def _values(self) -> dict[str, Any]:
        excluded = {"vary", "sweep", "cases", "measured", "accuracy"}
        return self.model_dump(by_alias=True, exclude=excluded)

    def _row_values(self) -> dict[str, Any]:
        """Return what a row of cases may set: also the accuracy, and a drive."""
        accuracy = self.accuracy.model_dump(exclude={"coverage"})
        return {**self._values(), "accuracy": accuracy, "sweep": dict.fromkeys(DRIVE, ())}


def _unknown_in(key: str, allowed: Sequence[str]) -> str:
    section, _, last = key.rpartition(".")
    if key.split(".")[0] in ("sweep", "accuracy", "vary"):
        return "cannot be varied"
    siblings = [name.rpartition(".")[2] for name in allowed if name.rpartition(".")[0] == section]
    return unknown_key(last, siblings) if siblings else unknown_key(key, allowed)


def _dotted_keys(
    values: Mapping[str, Any], prefix: str = "", *, leaves: bool = False
) -> Iterator[str]:
    """Yield the keys of sections and below them; ``leaves`` without those of sections."""
    for key, value in values.items():
        if not (leaves and isinstance(value, dict)):
            yield prefix + key
        if isinstance(value, dict):
            yield from _dotted_keys(value, f"{prefix}{key}.", leaves=leaves)


class CouponStudy(SectionModel):
    """A study of the coupon alone: what the particles dissipate, and on what it depends."""

    name: Text
    """Name of the results folder; by default the name of the file."""
    title: Text = ""
    """Title of the report."""
    assumptions: tuple[Text, ...] = ()
    """Assumptions where the source gives no value; printed in the report."""
    coupon: VariedCoupon | None = None
    """The honeycomb coupon that LIGGGHTS shakes."""

    def mistakes(self) -> Iterator[Mistake]:
        if is_formula(self.title):  # the source of the rows of an atlas
            yield Mistake(("title",), f"must not begin with {self.title.strip()[0]!r}")
        yield from mistakes_of_name(self.name)
        if self.coupon is None and type(self) is CouponStudy:
            yield Mistake((), "must have a section coupon, panel, or both")

    @property
    def coupons(self) -> Mapping[str, Coupon]:
        """Coupons to simulate by name, that of the section first."""
        return {SECTION: self.coupon} if self.coupon else {}

    @property
    def is_coupled(self) -> bool:
        """Whether panel and particles are integrated together; see `Study`."""
        return False
