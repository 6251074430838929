"""The file of an identification: a damper, what was measured of it, and the shaker."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

from pydantic import BeforeValidator

from pidpanel.study.base import Fill, RelativeError, SectionModel, Text, file_in
from pidpanel.study.coupon import Coupon
from pidpanel.study.coupon_study import mistakes_of_name
from pidpanel.study.mistakes import Mistake
from pidpanel.study.quantity import Quantity, whole
from pidpanel.study.requirements import REMEDY, mistakes_of_coupon, mistakes_of_fill
from pidpanel.study.stated_dampers import MassPerArea
from pidpanel.study.sweep import Frequency, Gamma

GIVEN = {"cell", "particles", "gravity_g", "gravity_direction"}  # keys of the coupon
# Remedy for beds outside the atlas
SIMULATION = "; a study with coupon.measured and coupon.vary simulates it (docs/identify.md)"
IDENTIFIED = ("restitution", "friction")  # keys of its particles that are not given


class Measured(SectionModel):
    """A measurement of the damper: C_e and m_a over tones, or force over acceleration."""

    file: Annotated[Path, file_in()]
    """CSV table of damping, or a universal file (data set 58) with force over acceleration."""
    acceleration_g: Gamma | None = None
    """Amplitude of all tones [g], for a file without amplitudes."""
    acceleration_rms_g: Annotated[float, Quantity(0.01, 1000, unit="gravities")] | None = None
    """Rms acceleration of a random test [g]."""
    spectrum: Annotated[Path, file_in()] | None = None
    """CSV table of the acceleration PSD of a random test, instead of ``acceleration_rms_g``."""
    relative_error: RelativeError | None = None
    """Standard error of C_e over itself, and of m_a over the mass of the particles, for a file
    without errors."""
    record: Annotated[int, whole(1, 10_000)] | None = None
    """Number of the data set 58 in a universal file that has several."""
    area_mm2: Annotated[float, Quantity(1, 1e8)] | None = None
    """Area of the damper's cells, over which a universal file has the force [mm²]."""
    fixture_mass_kg: Annotated[float, Quantity(0, 1e4)] = 0.0
    """Mass of cell and fixture, which the force moves too [kg]."""

    def mistakes(self) -> Iterator[Mistake]:
        levels = ("acceleration_g", "acceleration_rms_g", "spectrum")
        stated = [key for key in levels if getattr(self, key) is not None]
        if len(stated) > 1:
            yield Mistake((stated[1],), f"not allowed together with {stated[0]}")


class ShakerLimits(SectionModel):
    """Limits of the shaker, for the proposal of a further test."""

    frequency_hz: tuple[Frequency, Frequency] = (20.0, 2000.0)
    """Lowest and highest frequency [Hz]."""
    acceleration_g: Gamma = 50.0
    """Largest acceleration amplitude [g]."""
    displacement_mm: Annotated[float, Quantity(1e-3, 1000, unit="millimetres")] = 10.0
    """Largest displacement amplitude [mm]."""

    def mistakes(self) -> Iterator[Mistake]:
        low, high = self.frequency_hz
        if low >= high:
            yield Mistake(("frequency_hz",), "must rise from the lowest to the highest")


def _as_file(value: Any) -> Any:
    return {"file": value} if isinstance(value, str | Path) else value


class Identification(SectionModel):
    """A measured damper whose particles are to be identified."""

    name: Text
    """Name of the results folder; by default the name of the file."""
    title: Text = ""
    """Title of the report."""
    coupon: Coupon
    """Cell, particles and gravity, as in a study; without restitution and friction."""
    fill_fraction: Fill | None = None
    """Number of particles over that of a full cell, r; without it r is identified too."""
    fill_fraction_error: Annotated[float, Quantity(1e-4, 0.5)] = 0.02
    """Standard error of the fill fraction."""
    particle_mass_per_area_kg_m2: MassPerArea | None = None
    """Mass of the particles over the area of the cells, if they were weighed [kg/m²]."""
    particle_mass_mg: Annotated[float, Quantity(1e-7, 1e8)] | None = None
    """Mean mass of a particle, if some were counted and weighed [mg]: it tells other sizes."""
    measured: Annotated[Measured, BeforeValidator(_as_file)]
    """The measurement; a path alone is its ``file``."""
    shaker: ShakerLimits = ShakerLimits()
    """Limits of the shaker."""

    def mistakes(self) -> Iterator[Mistake]:
        yield from mistakes_of_name(self.name)
        for key in sorted(self.coupon.model_fields_set - GIVEN):
            message = f"not allowed here; allowed are {', '.join(sorted(GIVEN))}"
            yield Mistake(("coupon", key), message)
        for key in IDENTIFIED:
            if key in self.coupon.particles.model_fields_set:
                yield Mistake(("coupon", "particles", key), "is identified; omit it")
        for keys, message, _ in mistakes_of_coupon(self.coupon):
            yield Mistake(("coupon", *keys), message.replace(REMEDY, SIMULATION))
        if self.fill_fraction is not None:
            yield from mistakes_of_fill(("fill_fraction",), self.fill_fraction)
        if "fill_fraction_error" in self.model_fields_set and self.fill_fraction is None:
            yield Mistake(("fill_fraction_error",), "only allowed with fill_fraction")
