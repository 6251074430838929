"""The section ``damping`` of a study: the damping models, and the target of a sweep."""

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, ClassVar, Literal

from pydantic import BeforeValidator, Field

from pidpanel.paths import DATA
from pidpanel.study.base import RelativeError, SectionModel, file_in
from pidpanel.study.dampers import Interpolation, WeighsAs
from pidpanel.study.mistakes import Mistake
from pidpanel.study.particles import Modulus
from pidpanel.study.quantity import Quantity, whole
from pidpanel.study.sweep import Gamma

Prior = Literal["closed_form", "atlas"]
ModelName = Literal[
    "stated", "dem", "paper_corrected", "paper_printed", "table", "coupled", "atlas"
]
REMOVED = "was removed; use 'coupled', the default for sound"
COUPLED: ModelName = "coupled"  # damping from panel and particles in one time integration


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

    def mistakes(self) -> Iterator[Mistake]:
        if self.kind == "stated" and self.by == "element":
            message = "only allowed for kind: patch; a stated acceleration holds for all elements"
            yield Mistake(("by",), message)
        if (self.kind == "stated") != (self.acceleration_g is not None):
            yield Mistake(("acceleration_g",), "required for kind: stated, not allowed otherwise")


class Coupled(SectionModel):
    """Coupled integration of panel and particles, for the damping model ``coupled``.

    Every scenario is run once, with its own packings and sound, for ``settle_s`` and then
    ``duration_s``. Further runs follow until every g rms is known to ``relative_error``, up to
    ``runs``.
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


def _without_removed(name: Any) -> Any:
    if name in ("random", "random_with_source"):
        raise ValueError(f"'{name}' {REMOVED}")
    return name


class Damping(SectionModel):
    """Damping models, the sources of C_e and m_a. The PSDs are computed with each of them."""

    removed_keys: ClassVar[Mapping[str, str]] = {
        "random": f"{REMOVED}, with the keys of damping.coupled",
        "target": "was removed, because its errors were too small; the whole of coupon.sweep is "
        "run",
        "tones": "was removed; use 'coupled', or extend coupon.sweep to the motions",
    }

    readings: (
        Annotated[
            tuple[Annotated[ModelName, BeforeValidator(_without_removed)], ...], Field(min_length=1)
        ]
        | None
    ) = None
    """Damping models. ``stated``: each patch as defined in ``dampers``. ``coupled``: panel and
    particles are integrated together. ``atlas``: C_e and m_a of coupons from a table of simulated
    beds, without LIGGGHTS. Patches without a coupon are as in ``stated`` in both. The others use
    the same damping for all patches: ``dem`` the section ``coupon`` under single tones,
    ``table`` the key below, ``paper_…`` the paper's law. The default is ``coupled`` where a
    scenario has a coupon, because sound is broadband. With ``level``,
    which is for single tones, with diagonal modal damping, or without a coupon, it is
    ``stated`` in a study with ``dampers``, else ``dem``."""
    level: Level = Level()
    """The acceleration amplitude for C_e."""
    table: Annotated[Path, file_in(DATA / "damping")] | None = None
    """CSV table of measured damping, for the damping model ``table``."""
    interpolation: Interpolation | None = None
    """Between the rows of the table: log (by default) or linear."""
    apparent_mass: WeighsAs | None = None
    """``particles``: m_a is the mass of the particles, for a table measured without it."""
    prior: Prior = "closed_form"
    """What surfaces of simulated coupons start from: closed forms, or the atlas of particle beds,
    with which fewer cases of the coupon give the same uncertainty."""
    coupled: Coupled = Coupled()
    """Settings of the damping model ``coupled``."""

    def mistakes(self) -> Iterator[Mistake]:
        readings = self.readings or ()
        if len(set(readings)) != len(readings):
            yield Mistake(("readings",), "must not contain a damping model twice")
        if ("table" in readings) != (self.table is not None):
            message = "required for the damping model 'table', not allowed otherwise"
            yield Mistake(("table",), message)
        for key in ("interpolation", "apparent_mass"):
            if getattr(self, key) is not None and self.table is None:
                yield Mistake((key,), "only allowed with table")
