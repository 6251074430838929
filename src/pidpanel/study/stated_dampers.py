"""Dampers whose damping is stated: by a law, a table or constants."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal, NamedTuple, Self

from pidpanel.columns import ColumnsError, read_rows
from pidpanel.constants import MOST_LOSS_FACTOR, MOST_OF_MASS
from pidpanel.paths import DATA
from pidpanel.study.base import SectionModel, Vector, file_in
from pidpanel.study.mistakes import Mistake
from pidpanel.study.quantity import Quantity

Law = Literal["paper_corrected", "paper_printed"]
Interpolation = Literal["log", "linear"]
EquivalentDamping = Annotated[float, Quantity(0, 1e8)]  # C_e [N s/m³]
ApparentMass = Annotated[float, Quantity(0, 1000, unit="mass_per_area")]  # m_a [kg/m²]
MassPerArea = Annotated[float, Quantity(1e-3, 1000, unit="mass_per_area")]  # m″ [kg/m²]
# η; what is above is taken for percent.
LossFactor = Annotated[float, Quantity(0, MOST_LOSS_FACTOR, unit="percent")]
WeighsAs = Literal["particles"]  # what m_a is: the mass of the particles


class ModelText(NamedTuple):
    """What pages and tables call a damping model, and its rank: the lowest answers first."""

    title: str
    source: str
    rank: int


LAWS: Mapping[Law, ModelText] = {
    "paper_corrected": ModelText("The paper's law, corrected", "law of the paper, corrected", 4),
    "paper_printed": ModelText("The paper's law, as printed", "law of the paper as printed", 5),
}


class DamperSection(SectionModel):
    """What all kinds of dampers have."""

    kind: ClassVar[str] = ""  # the key that makes it what it is

    like: str | None = None
    """Another damper of the section: its keys are those of this one, except for what is stated
    here. A damper of another kind is then another damping model of the same particles."""

    @property
    def text(self) -> ModelText:
        """Title and source of its damping model."""
        return ModelText("Constants", "constants", 1)

    @property
    def needs_fill(self) -> bool:
        """Whether its damping depends on the fill of the patch."""
        return self.kind in ("law", "particles")

    @property
    def states_error(self) -> bool:
        """Whether it comes with an error of its damping."""
        return True

    @property
    def is_massless(self) -> bool:
        """Whether particles of a stated mass act without any."""
        return False

    @property
    def bed(self) -> Any:
        """What it is apart from its damping model; None for a model of any particles."""
        return self.model_dump()

    def with_steady_acceleration(self, acceleration_g: Vector | None) -> Self:
        """Return the damper under a steady acceleration [g]; what is stated does not know it."""
        return self

    def in_frame(self, normal: Vector) -> Self:
        """Return the damper in the frame of a patch whose normal (x, y, z) is not z."""
        return self

    def largest_mass_per_area(self, frequency: float) -> float:
        """Return about the largest apparent mass [kg/m²], for the choice of shapes; 0 if unknown.

        A dashpot is replaced by the mass of equal inertia, C_e/ω, at the highest frequency of the
        response [Hz].
        """
        return 0.0

    def mass_of_rows(self, fill_fraction: float | None) -> float:
        """Return the largest m_a in the rows of its table about a fill [kg/m²]; 0 without any."""
        return 0.0


class LawDamper(DamperSection):
    """A law of the paper; without mass."""

    kind = "law"

    law: Law
    """``paper_corrected``, or as printed, which has no steady response."""

    @property
    def text(self) -> ModelText:
        """Title and source of its damping model."""
        return LAWS[self.law]

    @property
    def bed(self) -> None:
        """None: the law is for any particles."""


class _FileDamper(DamperSection):
    """A damper of a CSV table."""

    interpolation: Interpolation | None = None
    """Between the rows of the table: log (by default) or linear."""

    @property
    def text(self) -> ModelText:
        """Title and source of its damping model."""
        return ModelText("Table", "table", 1)

    @property
    def file(self) -> Path:
        """Its table."""
        file: Path = getattr(self, self.kind)
        return file

    @cached_property
    def rows(self) -> list[dict[str, float]]:
        """Rows of its table; none where it cannot be read, which is reported elsewhere."""
        try:
            table = read_rows(self.file)
            cells = (map(float, row) for _, row in table.rows)
            return [dict(zip(table.header, row, strict=True)) for row in cells]
        except (ColumnsError, ValueError):
            return []

    @cached_property
    def columns(self) -> set[str]:
        """Names of the columns of its table."""
        return set().union(*self.rows[:1])

    @property
    def needs_fill(self) -> bool:
        """Whether its damping depends on the fill of the patch."""
        return "fill_fraction" in self.columns

    @property
    def states_error(self) -> bool:
        """Whether it comes with an error of its damping."""
        return any("error" in column for column in self.columns)

    @property
    def is_massless(self) -> bool:
        """Whether particles of a stated mass act without any."""
        return is_massless(self.columns)

    def mass_of_rows(self, fill_fraction: float | None) -> float:
        """Return the largest m_a of the rows on both sides of a fill [kg/m²]."""
        rows, fills = self.rows, sorted({row.get("fill_fraction", 1.0) for row in self.rows})
        if self.needs_fill and fill_fraction is not None:
            low = max((fill for fill in fills if fill <= fill_fraction), default=fills[0])
            high = min((fill for fill in fills if fill >= fill_fraction), default=fills[-1])
            rows = [row for row in rows if low <= row["fill_fraction"] <= high]
        return max((max(self._masses(row)) for row in rows), default=0.0)

    def _masses(self, row: Mapping[str, float]) -> Iterator[float]:
        yield row.get("apparent_mass_kg_m2", 0.0)
        if row.get("frequency_hz"):
            yield row.get("impedance_imag_n_s_m3", 0.0) / (2 * math.pi * row["frequency_hz"])


class TableDamper(_FileDamper):
    """Measured or assumed damping in a table."""

    kind = "table"

    table: Annotated[Path, file_in(DATA / "damping")]
    """CSV table of C_e or η over fill fraction, frequency and amplitude."""
    apparent_mass: WeighsAs | None = None
    """``particles``: m_a is the mass of the particles, where the damping was measured without it:
    a table without a column ``apparent_mass_kg_m2``."""

    @property
    def is_massless(self) -> bool:
        """Whether particles of a stated mass act without any."""
        return self.apparent_mass is None and super().is_massless

    def _masses(self, row: Mapping[str, float]) -> Iterator[float]:
        yield from super()._masses(row)
        if self.apparent_mass is not None:
            yield row.get("particle_mass_per_area_kg_m2", 0.0)


class ImpedanceDamper(_FileDamper):
    """A measured impedance."""

    kind = "impedance"

    impedance: Annotated[Path, file_in(DATA / "damping")]
    """CSV table of the impedance per area Z = C_e + iω m_a over frequency, for every fill fraction
    and amplitude."""


class _StatedDamper(DamperSection):
    """The same damping at every frequency, fill fraction and amplitude."""

    apparent_mass_kg_m2: ApparentMass | None = None
    """m_a at every frequency, fill fraction and amplitude [kg/m²]; 0 by default."""
    apparent_mass: WeighsAs | None = None
    """``particles``: m_a is the mass of the particles, where the damping was measured without
    it."""
    apparent_mass_error_kg_m2: ApparentMass | None = None
    """Its standard error [kg/m²]."""
    particle_mass_per_area_kg_m2: MassPerArea | None = None
    """Mass of the damper per area [kg/m²]; by default its apparent mass. Also m″ of a loss factor,
    unless ``patch_mass_per_area_kg_m2`` is given."""

    error: ClassVar[str] = ""  # name of the error of the value, which is carried relative to it

    @property
    def states_error(self) -> bool:
        """Whether it comes with an error of its damping; dead weight has none to state.

        Examples
        --------
        >>> ConstantSection(equivalent_damping_n_s_m3=0, apparent_mass_kg_m2=3).states_error
        True
        """
        return getattr(self, self.kind) == 0 or bool(getattr(self, self.error))

    @property
    def is_massless(self) -> bool:
        """Whether particles of a stated mass act without any."""
        has_mass = self.apparent_mass is not None or self.apparent_mass_kg_m2 is not None
        return self.particle_mass_per_area_kg_m2 is not None and not has_mass

    def mistakes(self) -> Iterator[Mistake]:
        weight = self.particle_mass_per_area_kg_m2
        if getattr(self, self.error) and getattr(self, self.kind) == 0:
            yield Mistake((self.error,), f"must be 0 where {self.kind} is 0, as it is relative")
        if self.apparent_mass_error_kg_m2 is not None and self.apparent_mass_kg_m2 is None:
            yield Mistake(("apparent_mass_error_kg_m2",), "only allowed with apparent_mass_kg_m2")
        if self.apparent_mass is not None:
            if self.apparent_mass_kg_m2 is not None:
                yield Mistake(("apparent_mass",), "not allowed with apparent_mass_kg_m2")
            if weight is None:
                yield Mistake(("apparent_mass",), "requires particle_mass_per_area_kg_m2")
        elif MOST_OF_MASS * (weight or math.inf) < (self.apparent_mass_kg_m2 or 0.0):
            message = f"more than {MOST_OF_MASS:g} times particle_mass_per_area_kg_m2 = "
            yield Mistake(("apparent_mass_kg_m2",), f"{message}{weight:g}; in g/m²?")

    def largest_mass_per_area(self, frequency: float) -> float:
        """Return m_a, the mass, or that of the inertia of C_e at a frequency [Hz] [kg/m²]."""
        return max(self.apparent_mass_kg_m2 or 0.0, self.particle_mass_per_area_kg_m2 or 0.0)


class ConstantSection(_StatedDamper):
    """Constant C_e; 0 for dead weight."""

    kind, error = "equivalent_damping_n_s_m3", "equivalent_damping_error_n_s_m3"

    equivalent_damping_n_s_m3: EquivalentDamping
    """C_e at every frequency, fill fraction and amplitude [N s/m³]; 0 for dead weight."""
    equivalent_damping_error_n_s_m3: EquivalentDamping | None = None
    """Its standard error [N s/m³]."""

    def largest_mass_per_area(self, frequency: float) -> float:
        """Return m_a, the mass, or that of the inertia of C_e at a frequency [Hz] [kg/m²]."""
        dashpot = self.equivalent_damping_n_s_m3 / (2 * math.pi * frequency)
        return max(super().largest_mass_per_area(frequency), dashpot)


class LossFactorDamper(_StatedDamper):
    """A constant loss factor."""

    kind, error = "loss_factor", "loss_factor_error"

    loss_factor: LossFactor
    """η in C_e = η m″ ω, with the mass m″ given by another key; a number, not percent."""
    loss_factor_error: LossFactor | None = None
    """Its standard error."""
    patch_mass_per_area_kg_m2: MassPerArea | None = None
    """m″ if the loss factor is that of the whole patch, panel and treatment [kg/m²]."""

    def mistakes(self) -> Iterator[Mistake]:
        yield from super().mistakes()
        if not (self.particle_mass_per_area_kg_m2 or self.patch_mass_per_area_kg_m2):
            message = "missing; required for loss_factor as its mass m″, unless "
            message += "patch_mass_per_area_kg_m2 (panel and treatment) is given"
            yield Mistake(("particle_mass_per_area_kg_m2",), message)


def is_massless(columns: set[str]) -> bool:
    """Return whether a table has a mass of the particles and no apparent mass."""
    acts = {"apparent_mass_kg_m2", "impedance_imag_n_s_m3"} & columns
    return "particle_mass_per_area_kg_m2" in columns and not acts
