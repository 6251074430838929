"""The section ``damping`` of a study: the motion at which damping is evaluated; coupled runs."""

from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal

from pidpanel.study.base import RelativeError, SectionModel
from pidpanel.study.mistakes import Mistake
from pidpanel.study.particles import Modulus
from pidpanel.study.quantity import Quantity, whole
from pidpanel.study.sweep import Gamma


class Level(SectionModel):
    """The acceleration amplitude Γ for C_e(r, f, Γ): a fixed value, or that of the patch."""

    kind: Literal["patch", "stated"] = "patch"
    """``patch``: the amplitude of the patch itself, by iteration; ``stated``: a fixed value."""
    acceleration_g: Gamma | None = None
    """Fixed acceleration amplitude Γ, in units of standard gravity."""
    by: Literal["patch", "element"] = "patch"
    """``patch``: the mean motion of the patch; ``element``: that of each mesh element in it."""
    outside: Literal["mark", "refuse"] = "mark"
    """Treatment of values outside the range of the cases or the table."""

    @classmethod
    def is_stated(cls, values: Any) -> bool:
        """Return whether the values of this section, as written, are not the default."""
        written = values if isinstance(values, Mapping) else {}
        return any(cls.model_fields[key].default != written[key] for key in written
                   if key in cls.model_fields)  # fmt: skip

    def mistakes(self) -> Iterator[Mistake]:
        if self.kind == "stated" and self.by == "element":
            message = "only allowed for kind: patch; a stated acceleration holds for all elements"
            yield Mistake(("by",), message)
        if (self.kind == "stated") != (self.acceleration_g is not None):
            yield Mistake(("acceleration_g",), "required for kind: stated, not allowed otherwise")


class Coupled(SectionModel):
    """Coupled integration of panel and particles, for dampers with ``model: coupled``.

    Every scenario is run once, with its own packings and sound, for ``settle_s`` and then
    ``duration_s``. Further runs follow until every g rms is known to ``relative_error``, up to
    ``runs``. Errors that runs do not reduce do not count: the error of softened contacts, and the
    residual beyond its scatter.
    """

    removed_keys: ClassVar[Mapping[str, str]] = {
        "scenarios": "was removed; every scenario with a coupon is run, keep only those"
    }

    relative_error: RelativeError = 0.02
    """Requested relative standard error of every rms acceleration."""
    duration_s: Annotated[float, Quantity(0.1, 100, unit="milliseconds")] = 1.6
    """Evaluated duration of each run [s]."""
    settle_s: Annotated[float, Quantity(0, 10, unit="milliseconds")] = 0.4
    """Discarded time before it [s]."""
    runs: Annotated[int, whole(1, 100)] = 4
    """Maximum runs per scenario."""
    stations: Annotated[int, whole(1, 100)] = 8
    """Stations of a patch, each with its own motion and cells."""
    cells: Annotated[int, whole(2, 200)] = 16
    """Simulated cells of a patch, equally many at every station."""
    youngs_modulus_mpa: Modulus | None = None
    """Young's modulus of the contacts [MPa]; by default the softest that lowers g rms by at most 2
    %, which is part of the error."""

    def mistakes(self) -> Iterator[Mistake]:
        if self.cells % self.stations:
            yield Mistake(("cells",), f"must be a multiple of stations = {self.stations}")


NEW = "dampers: {acrylic: {cell: …, particles: …, model: coupled}}"  # form of a damper


class Damping(SectionModel):
    """The motion at which damping is evaluated, and coupled runs."""

    removed_keys: ClassVar[Mapping[str, str]] = {
        "readings": f"was removed; each damper has its model, such as {NEW}, table: …, or law: "
        "paper_corrected, and a list of dampers in a scenario compares them",
        "table": "moved to a damper: dampers: {lab: {table: …}}",
        "interpolation": "moved to a damper: dampers: {lab: {table: …, interpolation: …}}",
        "apparent_mass": "moved to a damper: dampers: {lab: {table: …, apparent_mass: particles}}",
        "prior": "moved to a damper: dampers: {acrylic: {particles: …, model: tones, prior: …}}",
        "random": f"was removed; the keys are those of damping.coupled, with {NEW}",
        "target": "was removed, because its errors were too small; the whole of the sweep is run",
        "tones": f"was removed; use {NEW}, or extend the sweep to the motions",
    }

    level: Level = Level()
    """The acceleration amplitude for C_e."""
    coupled: Coupled = Coupled()
    """Settings of the coupled runs, for dampers with ``model: coupled``."""
