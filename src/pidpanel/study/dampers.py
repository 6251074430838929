"""The section ``dampers`` of a study: what a patch can be filled with, one model for each."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Literal

from pidpanel.columns import ColumnsError, read_rows
from pidpanel.constants import MOST_LOSS_FACTOR, MOST_OF_MASS
from pidpanel.paths import DATA
from pidpanel.study.base import SectionModel, file_in
from pidpanel.study.coupon import Coupon
from pidpanel.study.mistakes import Mistake
from pidpanel.study.quantity import Quantity
from pidpanel.text_files import TextFileError, read_bytes

if TYPE_CHECKING:
    from pidpanel.study import Study

Law = Literal["paper_corrected", "paper_printed"]
Interpolation = Literal["log", "linear"]
EquivalentDamping = Annotated[float, Quantity(0, 1e8)]  # C_e [N s/m³]
ApparentMass = Annotated[float, Quantity(0, 1000, unit="mass_per_area")]  # m_a [kg/m²]
MassPerArea = Annotated[float, Quantity(1e-3, 1000, unit="mass_per_area")]  # m″ [kg/m²]
# η; what is above is taken for percent.
LossFactor = Annotated[float, Quantity(0, MOST_LOSS_FACTOR, unit="percent")]
Kind = Literal["coupon", "law", "table", "impedance", "equivalent_damping_n_s_m3", "loss_factor"]

WeighsAs = Literal["particles"]  # what m_a is: the mass of the particles

MASSES = (
    "apparent_mass", "apparent_mass_kg_m2", "apparent_mass_error_kg_m2",
    "particle_mass_per_area_kg_m2",
)  # fmt: skip
# Errors that are carried relative to their values, by those.
RELATIVE_ERRORS = {
    "equivalent_damping_n_s_m3": "equivalent_damping_error_n_s_m3",
    "loss_factor": "loss_factor_error",
}
# Kinds of a damper, by the key that selects it, and the further keys that are allowed with it.
ALLOWED: Mapping[Kind, tuple[str, ...]] = {
    "coupon": (),
    "law": (),
    "table": ("interpolation", "apparent_mass"),
    "impedance": ("interpolation",),
    "equivalent_damping_n_s_m3": ("equivalent_damping_error_n_s_m3", *MASSES),
    "loss_factor": ("loss_factor_error", *MASSES, "patch_mass_per_area_kg_m2"),
}


def is_massless_table(table: Path) -> bool:
    """Return whether a table has a mass of the particles and no apparent mass."""
    names = _columns(table)
    acts = {"apparent_mass_kg_m2", "impedance_imag_n_s_m3"} & set(names)
    return "particle_mass_per_area_kg_m2" in names and not acts


def mass_in_table(file: Path, fill_fraction: float | None, weighs_as: WeighsAs | None) -> float:
    """Return the largest m_a of a table about a fill fraction [kg/m²]; 0 where it cannot be read.

    What is wrong with a table is reported where its damping is read.
    """
    try:
        table = read_rows(file)
        rows = [dict(zip(table.header, map(float, cells), strict=True)) for _, cells in table.rows]
    except (ColumnsError, ValueError):
        return 0.0
    fills = sorted({row["fill_fraction"] for row in rows if "fill_fraction" in row})
    if fills and fill_fraction is not None:
        # the rows on both sides of the fill
        low = max((fill for fill in fills if fill <= fill_fraction), default=fills[0])
        high = min((fill for fill in fills if fill >= fill_fraction), default=fills[-1])
        rows = [row for row in rows if low <= row["fill_fraction"] <= high]
    masses = [0.0]
    for row in rows:
        if weighs_as == "particles":
            masses.append(row.get("particle_mass_per_area_kg_m2", 0.0))
        masses.append(row.get("apparent_mass_kg_m2", 0.0))
        if row.get("frequency_hz"):
            omega = 2 * math.pi * row["frequency_hz"]
            masses.append(row.get("impedance_imag_n_s_m3", 0.0) / omega)
    return max(masses)


class Damper(SectionModel):
    """One damper: a coupon, a law, a table, an impedance, constants, or a loss factor.

    Exactly one of ``coupon``, ``law``, ``table``, ``impedance``, ``equivalent_damping_n_s_m3`` and
    ``loss_factor`` is given.
    """

    coupon: Coupon | None = None
    """Cells and particles, simulated like the section ``coupon``."""
    law: Law | None = None
    """A law of the paper; without mass."""
    table: Annotated[Path, file_in(DATA / "damping")] | None = None
    """CSV table of C_e or η over fill fraction, frequency and amplitude."""
    impedance: Annotated[Path, file_in(DATA / "damping")] | None = None
    """CSV table of the impedance per area Z = C_e + iω m_a over frequency, for every fill fraction
    and amplitude."""
    interpolation: Interpolation | None = None
    """Between the rows of a table: log (by default) or linear."""
    equivalent_damping_n_s_m3: EquivalentDamping | None = None
    """C_e at every frequency, fill fraction and amplitude [N s/m³]; 0 for dead weight."""
    equivalent_damping_error_n_s_m3: EquivalentDamping | None = None
    """Its standard error [N s/m³]."""
    apparent_mass_kg_m2: ApparentMass | None = None
    """m_a at every frequency, fill fraction and amplitude [kg/m²]; 0 by default."""
    apparent_mass: WeighsAs | None = None
    """``particles``: m_a is the mass of the particles, where the damping was measured without it:
    a table without a column ``apparent_mass_kg_m2``, or constants."""
    apparent_mass_error_kg_m2: ApparentMass | None = None
    """Its standard error [kg/m²]."""
    loss_factor: LossFactor | None = None
    """η in C_e = η m″ ω, with the mass m″ given by another key; a number, not percent."""
    loss_factor_error: LossFactor | None = None
    """Its standard error."""
    particle_mass_per_area_kg_m2: MassPerArea | None = None
    """Mass of the damper per area [kg/m²]; by default its apparent mass. Also m″ of the loss
    factor, unless ``patch_mass_per_area_kg_m2`` is given."""
    patch_mass_per_area_kg_m2: MassPerArea | None = None
    """m″ if the loss factor is that of the whole patch, panel and treatment [kg/m²]."""

    @property
    def kind(self) -> Kind:
        """The key that makes the damper what it is."""
        return self._kinds()[0]

    def mistakes(self) -> Iterator[Mistake]:
        kinds = self._kinds()
        if len(kinds) != 1:
            actual = f"not {' and '.join(kinds)}" if kinds else "not none"
            yield Mistake((), f"must have exactly one of {', '.join(ALLOWED)}, {actual}")
            return
        (kind,) = kinds
        names = [name for name in type(self).model_fields if getattr(self, name) is not None]
        for name in names:
            if name not in (kind, *ALLOWED[kind]):
                suitable = [owner for owner, allowed in ALLOWED.items() if name in allowed]
                yield Mistake((name,), f"only allowed with {' or '.join(suitable)}")
        yield from self._mistakes_of_errors()
        if self.loss_factor is not None and not (
            self.particle_mass_per_area_kg_m2 or self.patch_mass_per_area_kg_m2
        ):
            message = "missing; required for loss_factor as its mass m″, unless "
            message += "patch_mass_per_area_kg_m2 (panel and treatment) is given"
            yield Mistake(("particle_mass_per_area_kg_m2",), message)
        if self.apparent_mass is not None:
            yield from self._mistakes_of_mass()
        elif MOST_OF_MASS * (self.particle_mass_per_area_kg_m2 or math.inf) < (
            self.apparent_mass_kg_m2 or 0.0
        ):
            message = f"more than {MOST_OF_MASS:g} times particle_mass_per_area_kg_m2 = "
            message += f"{self.particle_mass_per_area_kg_m2:g}; in g/m²?"
            yield Mistake(("apparent_mass_kg_m2",), message)
        yield from self.coupon.mistakes_with_panel() if self.coupon else ()

    @property
    def is_of_a_fill(self) -> bool:
        """Whether its damping depends on the fill of the patch."""
        if self.table is None:
            return self.kind in ("coupon", "law")
        return "fill_fraction" in _columns(self.table)

    @property
    def states_error(self) -> bool:
        """Whether it comes with an error of its damping.

        Examples
        --------
        >>> Damper(law="paper_corrected").states_error
        False
        >>> Damper(equivalent_damping_n_s_m3=0, apparent_mass_kg_m2=3).states_error  # dead weight
        True
        """
        table = self.table or self.impedance
        if table is not None:
            return any("error" in column for column in _columns(table))
        for name, error in RELATIVE_ERRORS.items():
            if getattr(self, name) is not None:
                return getattr(self, name) == 0 or bool(getattr(self, error))
        return self.coupon is not None

    @property
    def is_massless(self) -> bool:
        """Whether particles of a stated mass act without any."""
        if self.apparent_mass is not None:
            return False
        file = self.table or self.impedance
        if file is not None:
            return is_massless_table(file)
        has_mass = self.particle_mass_per_area_kg_m2 is not None
        return has_mass and self.apparent_mass_kg_m2 is None

    def mass_of_rows(self, fill_fraction: float | None) -> float:
        """Return the largest m_a in the rows of its table about a fill [kg/m²]; 0 without any."""
        file = self.table or self.impedance
        return 0.0 if file is None else mass_in_table(file, fill_fraction, self.apparent_mass)

    def largest_mass_per_area(self, frequency: float) -> float:
        """Return about the largest apparent mass [kg/m²], for the choice of shapes; 0 if unknown.

        A dashpot is replaced by the mass of equal inertia, C_e/ω, at the highest frequency of the
        response [Hz].
        """
        if self.coupon is not None:
            return self.coupon.largest_mass_per_area
        mass = max(self.apparent_mass_kg_m2 or 0.0, self.particle_mass_per_area_kg_m2 or 0.0)
        dashpot = (self.equivalent_damping_n_s_m3 or 0.0) / (2 * math.pi * frequency)
        return max(mass, dashpot)

    def _mistakes_of_mass(self) -> Iterator[Mistake]:
        """Yield an m_a that is given twice, or of particles whose mass is not known."""
        if self.apparent_mass_kg_m2 is not None:
            yield Mistake(("apparent_mass",), "not allowed with apparent_mass_kg_m2")
        if self.table is None and self.particle_mass_per_area_kg_m2 is None:
            yield Mistake(("apparent_mass",), "requires particle_mass_per_area_kg_m2")

    def _mistakes_of_errors(self) -> Iterator[Mistake]:
        """Yield errors without their value; those of C_e and η are carried relative to it."""
        for name, error in RELATIVE_ERRORS.items():
            if getattr(self, error) and getattr(self, name) == 0:
                yield Mistake((error,), f"must be 0 where {name} is 0, because it is relative")
        if self.apparent_mass_error_kg_m2 is not None and self.apparent_mass_kg_m2 is None:
            yield Mistake(("apparent_mass_error_kg_m2",), "only allowed with apparent_mass_kg_m2")

    def _kinds(self) -> tuple[Kind, ...]:
        return tuple(name for name in ALLOWED if getattr(self, name) is not None)


def _columns(table: Path) -> list[str]:
    try:
        lines = read_bytes(table).decode("utf-8-sig", errors="replace").splitlines()
    except TextFileError:  # reported where the table is read
        return []
    header = next((line for line in lines if line.partition("#")[0].strip()), "")
    return [name.strip() for name in header.partition("#")[0].split(",")]


def damper_masses(study: Study) -> dict[str, float]:
    """Return about the heaviest damper of each patch that a scenario fills [kg/m²].

    The basis follows the panel with these masses, whatever the fills of its scenarios. 0 where the
    mass is not known before the run, as of a table.
    """
    highest = study.response.frequency_hz[1]
    masses: dict[str, float] = {}
    for filling in study.fillings:
        damper, mass = study.damper_of(filling), 0.0
        if damper is not None and study.response.damper_mass:
            mass = damper.largest_mass_per_area(highest)
        masses[filling.patch] = max(masses.get(filling.patch, 0.0), mass)
    return masses


def resolved_masses(study: Study) -> dict[str, float]:
    """Return about the heaviest damper of each patch that the mesh resolves [kg/m²].

    Those of `damper_masses`, and m_a in the rows of tables.
    """
    masses = damper_masses(study)
    if not study.response.damper_mass:
        return masses
    common = study.damping.table if "table" in study.readings else None
    for filling in study.fillings:
        damper = study.damper_of(filling)
        mass = 0.0 if damper is None else damper.mass_of_rows(filling.fill_fraction)
        if common is not None:
            weighs_as = study.damping.apparent_mass
            mass = max(mass, mass_in_table(common, filling.fill_fraction, weighs_as))
        masses[filling.patch] = max(masses[filling.patch], mass)
    return masses
