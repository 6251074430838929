"""The section ``coupon`` of a study: cells, particles, contacts, and what of them is varied."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from typing import Annotated, Any

from pydantic import Field, ValidationError, ValidationInfo, field_validator, model_validator

from pidpanel.columns import ColumnsError, LineFaults
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.geometry.cells import ShapeName
from pidpanel.paths import TEMPLATES
from pidpanel.study.base import Fraction, RelativeError, SectionModel, file_in, found_file
from pidpanel.study.mistakes import Keys, Mistake, Mistakes, dotted, mistakes_of, unknown_key
from pidpanel.study.particles import Particles, Stiffness, Walls
from pidpanel.study.quantity import Quantity, whole
from pidpanel.study.sweep import USUAL_SWEEP, Sweep, read_cases, sweep_of

MOST_VARIANTS = 1000  # combinations that ``vary`` may have
MOST_RUNS = 200_000  # runs that a sweep may have; twice as many as have been run
DRIVE = ("fill_fraction", "frequency_hz", "acceleration_g", "displacement_mm")  # of a row of cases
MOST_SPHERES = 1_000_000  # spheres that a run may have: a step of them takes a second


class Cell(SectionModel):
    """The honeycomb cell, and the number of cells per run."""

    shape: ShapeName = "hexagon"
    """Cross-section of the cell."""
    across_flats_mm: Annotated[float, Quantity(0.5, 500, unit="small_millimetres")] = 6.35
    """Width of a hexagon between two sides; side of a square; diameter of a circle [mm]. On a
    sandwich whose core has a grade, hexagons have its cell size by default."""
    depth_mm: Annotated[float, Quantity(0.5, 1000, unit="small_millimetres")] = 25.0
    """Depth of the cell between its two closed ends [mm]; on a sandwich by default the thickness of
    its core."""
    count: Annotated[int, whole(1, 200)] = 5
    """Cells per run, shaken side by side; they share only the drive."""

    @property
    def across_flats(self) -> float:
        """Width of the cell [m]."""
        return self.across_flats_mm * 1e-3

    @property
    def depth(self) -> float:
        """Depth of the cell [m]."""
        return self.depth_mm * 1e-3


class Accuracy(SectionModel):
    """A case runs until its target error or ``max_cycles``, whichever comes first."""

    relative_error: RelativeError = 0.05
    """Requested relative standard error of C_e; a case stops when it is reached."""
    seeds: Annotated[int, whole(1, 50)] = 2
    """Number of packings per case, with one run each."""
    min_cycles: Annotated[int, whole(8, 100000)] = 12
    """Minimum cycles of a run."""
    min_time_s: Annotated[float, Quantity(0, 10, unit="milliseconds")] = 0.05
    """Minimum simulated time [s]. A bed adapts to its drive in tens of milliseconds at any
    frequency, so slowly that a few cycles look steady."""
    max_cycles: Annotated[int, whole(8, 100000)] = 400
    """Maximum cycles of a run."""
    state_seeds: Annotated[int, whole(1, 50)] = 4
    """Number of seeds if the cells of a bed near the jump (``stiffness.crossing``) end in several
    states of motion."""
    state_cycles: Annotated[int, whole(0, 100000)] = 150
    """Minimum cycles of these seeds, up to ``max_cycles``; 0 switches the search for states off."""
    coverage: Fraction = 1.0
    """Required share of successful cases; below it the study stops."""

    def mistakes(self) -> Iterator[Mistake]:
        if self.max_cycles < self.min_cycles:
            yield Mistake(("max_cycles",), f"must be at least min_cycles = {self.min_cycles}")


Component = Annotated[float, Quantity(-1e6, 1e6)]  # of a direction


class Coupon(SectionModel):
    """The shaken honeycomb coupon."""

    cell: Cell = Cell()
    """The honeycomb cell."""
    particles: Particles = Particles()
    """The particles and their contacts."""
    walls: Walls = Walls()
    """Contacts with the cell walls, where they differ."""
    gravity_g: Annotated[float, Quantity(0, 10, unit="gravities")] = 1.0
    """Acceleration of gravity [g]; 0 for none."""
    gravity_direction: tuple[Component, Component, Component] = (0.0, 0.0, -1.0)
    """Direction of gravity. z is normal to the panel and the direction of the motion, so
    (0, 0, −1) is a horizontal panel and (1, 0, 0) an upright one."""
    stiffness: Stiffness = Stiffness()
    """Softening of the contacts, to save time."""
    time_step_rayleigh: Annotated[float, Quantity(0, 0.3, low_itself=False, unit="percent")] = 0.15
    """Time step over the Rayleigh time of a particle."""
    samples_per_cycle: Annotated[int, whole(20, 2000)] = 100
    """Samples of the momentum per cycle, from which C_e and m_a are computed."""
    sweep: Sweep = USUAL_SWEEP
    """The drives: fills, frequencies and amplitudes. The damping models ``coupled`` and ``atlas``
    need none, nor does a coupon with ``cases``."""
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
    with the simulated cases and the atlas."""
    accuracy: Accuracy = Accuracy()
    """How long each case runs."""
    deck: Annotated[Path, file_in(TEMPLATES)] | None = None
    """Your own deck template instead of ``templates/shake.in.j2``."""

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

    @property
    def varied_values(self) -> Mapping[str, tuple[Any, ...]]:
        """Values of each key of ``vary``, or of each in the table of cases besides the drive."""
        if self.cases is None:
            return self.vary
        rows = [row.inputs for row in read_cases(self.cases)]
        return {key: tuple(dict.fromkeys(row[key] for row in rows)) for key in rows[0]}

    def mistakes_with_panel(self) -> Iterator[Mistake]:
        """Yield keys that only a study of the coupon alone may have."""
        for key in ("vary", "cases", "measured"):
            if getattr(self, key):
                yield Mistake(("coupon", key), "only allowed in a study without a panel")

    @property
    def decks(self) -> tuple[Path, ...]:
        """Deck templates instead of ``templates/shake.in.j2``."""
        return tuple(deck for deck in (self.deck, *self.vary.get("deck", ())) if deck is not None)

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

    @property
    def diameters(self) -> tuple[float, ...]:
        """Diameters of the particles [m]: those of the sweep, or the one of the particles."""
        return tuple(d * 1e-3 for d in self.sweep.diameter_mm or (self.particles.diameter_mm,))

    @property
    def gravity(self) -> float:
        """Acceleration of gravity [m/s²]."""
        return self.gravity_g * STANDARD_GRAVITY

    @property
    def largest_mass_per_area(self) -> float:
        """Approximate mass per area of the particles at the highest fill [kg/m²].

        Of spheres in random close packing, 0.64, to the height r times the depth.
        """
        fill_fraction = max(self.sweep.fill_fraction)
        density = max(self.particles.effective_density(d) for d in self.diameters)
        return 0.64 * density * self.cell.depth * fill_fraction

    def mistakes(self) -> Iterator[Mistake]:
        if not any(self.gravity_direction):
            message = "must not be zero; for no gravity set gravity_g: 0"
            yield Mistake(("gravity_direction",), message)
        # 9.78 to 9.84 m/s² all over the earth
        if abs(self.gravity_g - STANDARD_GRAVITY) < 0.03:
            message = f"must be from 0 to 10, and {self.gravity_g:g} m/s² would be 1"
            yield Mistake(("gravity_g",), message)
        if self.measured is not None and (self.vary or self.cases or len(self.diameters) > 1):
            message = "not allowed together with vary, cases or several diameters"
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

    def _mistakes_of_amount(self, variants: int) -> Iterator[Mistake]:
        """Yield a sweep without cases, or with more runs or spheres than can be run."""
        sweep, cell = self.sweep, self.cell
        drives = sweep.drive_count()
        if not drives:
            message = f"leaves out every combination; the slowest moves at {sweep.slowest():.2g} "
            yield Mistake(("sweep", "max_velocity_m_s"), f"{message}m/s")
        cases = drives * len(sweep.fill_fraction) * len(self.diameters) * variants
        runs = cases * self.accuracy.seeds
        if runs > MOST_RUNS:
            message = f"{cases} cases, {runs} runs; allowed are {MOST_RUNS} runs"
            yield Mistake(("sweep",), message)
        volume = cell.count * cell.across_flats**2 * cell.depth * max(sweep.fill_fraction)
        spheres = 0.64 * volume / (math.pi / 6 * min(self.diameters) ** 3)
        if spheres > MOST_SPHERES:
            keys: Keys = ("sweep" if sweep.diameter_mm else "particles", "diameter_mm")
            message = f"about {spheres:.1g} spheres in a run; allowed are {MOST_SPHERES}"
            yield Mistake(keys, message)

    def _mistakes_of_sizes(self) -> Iterator[Mistake]:
        widest = 0.9 * min(self.cell.across_flats, self.cell.depth)
        for index, diameter in enumerate(self.diameters):
            keys: Keys = ("particles", "diameter_mm")
            if self.sweep.diameter_mm:
                keys = ("sweep", "diameter_mm", index)
            sizes = self.particles.distribution.sizes(diameter)
            if sizes.largest > widest:
                message = f"the largest particle, {sizes.largest * 1e3:g} mm, must be at most 0.9 "
                message += f"of the cell's across_flats_mm = {self.cell.across_flats_mm:g} and "
                yield Mistake(keys, f"{message}depth_mm = {self.cell.depth_mm:g}")
            if sizes.smallest < 0.4 * sizes.largest:
                message = (
                    f"the smallest particle, {sizes.smallest * 1e3:g} mm, must be at least 0.4 "
                )
                message += f"of the largest, {sizes.largest * 1e3:g} mm: other mixtures separate "
                yield Mistake(("particles", "distribution"), f"{message}by size")

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
        for chosen in self._combinations() if set(self.vary) <= set(allowed) else ():
            try:
                self._variant(chosen)
            except ValidationError as error:
                for mistake in mistakes_of(error, Coupon):
                    combinations.setdefault(mistake, chosen)
        yield from (self._in_vary(mistake, chosen) for mistake, chosen in combinations.items())

    def _mistakes_of_cases(self, file: Path) -> Iterator[Mistake]:
        """Yield columns that are no keys, and rows that are no coupon."""
        rows = read_cases(file)
        allowed = [key for key in _dotted_keys(self._row_values(), leaves=True) if key != "deck"]
        unknown = [key for key in rows[0].values if key not in allowed]
        for key in unknown:
            yield Mistake(("cases",), f"column {key}: {_unknown_in(key, allowed)}")
        if unknown:
            return
        wrong = LineFaults(file)
        for line, values in rows:
            try:
                self._variant(values)
            except ValidationError as error:
                for keys, message, _ in mistakes_of(error, Coupon):
                    key = dotted(tuple(part for part in keys if isinstance(part, str)))
                    setting = f"{key} = {values[key]}" if key in values else key
                    wrong.add(line, f"{setting}: {message}", f"{key}: {message.partition(';')[0]}")
        if wrong:
            faults = ColumnsError(wrong.texts()).faults
            yield from (Mistake(("cases",), fault) for fault in faults)

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
        if self.cases is not None:
            rows = read_cases(self.cases)
            return tuple((row.inputs, self._variant(row.values)) for row in rows)
        if not self.vary:
            return (({}, self),)
        return tuple((chosen, self._variant(chosen)) for chosen in self._combinations())

    def _combinations(self) -> Iterator[dict[str, Any]]:
        if self.vary:
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
