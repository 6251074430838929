"""The section ``damping`` of a study: the readings of C_e and m_a, and tones beside a sweep."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, model_validator

from pidpanel.paths import DATA
from pidpanel.study.base import Model, RelativeError
from pidpanel.study.coupon import Gamma, Modulus
from pidpanel.study.dampers import Interpolation
from pidpanel.study.files import file_in
from pidpanel.study.mistakes import Mistake, Mistakes
from pidpanel.study.quantity import MILLISECONDS, Quantity, whole

Reading = Literal[
    "stated",
    "dem",
    "paper_corrected",
    "paper_printed",
    "table",
    "coupled",
]
NEIGHBOURS_DB = 3.0
"""Farthest level to which what a coupled run found is carried [dB]: beds begin to cross their gap
within some decibels, and push a thousand times as much then."""
COUPLED: Reading = "coupled"
"""Reading of panel and particles in one time integration."""
REMOVED = ("random", "random_with_source")
"""Readings of coupons driven at random, which there were before."""


class Level(Model):
    """The acceleration at which C_e(r, f, Γ) is read: a stated one, or the patch's own."""

    kind: Literal["patch", "stated"] = "patch"
    """``patch``: the amplitude at which the patch itself moves, found by iteration; ``stated``:
    a fixed one."""
    acceleration_g: Gamma | None = None
    """Stated acceleration amplitude Γ, in units of standard gravity."""
    by: Literal["patch", "element"] = "patch"
    """Whose motion it is: the mean over the patch, or that of each element of the mesh in it."""
    outside: Literal["mark", "refuse"] = "mark"
    """What becomes of values outside the simulated range."""

    def mistakes(self) -> Iterator[Mistake]:
        """Yield a stated acceleration that is missing or not allowed, and elements beside one."""
        if self.kind == "stated" and self.by == "element":
            yield Mistake(("by",), "only allowed for kind: patch; a stated motion is one for all")
        if (self.kind == "stated") != (self.acceleration_g is not None):
            yield Mistake(("acceleration_g",), "required for kind: stated, not allowed otherwise")


class Tones(Model):
    """Further cases where the scenarios read C_e: at the motion of their own patches.

    Once the sweep is run, rounds of at most ``batch`` tones follow at the fills and accelerations
    of the scenarios, each of those that reduce the errors most: until the relative standard error
    of every rms acceleration is below ``relative_error`` and that of C_e along every scenario
    below ``damping_error``, or ``most`` have been run.
    """

    relative_error: RelativeError = 0.02
    """Wanted relative standard error of every rms acceleration."""
    damping_error: RelativeError = 0.1
    """Wanted standard error of ln C_e along every scenario."""
    batch: Annotated[int, whole(1, 10_000)] = 16
    """Most tones of a round."""
    most: Annotated[int, whole(1, 10_000)] = 32
    """Most tones in all."""


class Coupled(Model):
    """How panel and particles are integrated together, for the reading ``coupled``.

    Every scenario is run once, with packings and a sound of its own, for ``settle_s`` and then
    ``duration_s``. Further runs follow until every g rms is known to ``relative_error``, up to
    ``runs``.
    """

    relative_error: RelativeError = 0.03
    """Wanted relative standard error of every rms acceleration."""
    duration_s: Annotated[float, Quantity(0.1, 100, units=MILLISECONDS)] = 1.6
    """Of the motion that counts in each run [s]."""
    settle_s: Annotated[float, Quantity(0, 10, units=MILLISECONDS)] = 0.4
    """Of the motion before it [s]."""
    runs: Annotated[int, whole(1, 100)] = 4
    """Most runs of each scenario."""
    stations: Annotated[int, whole(1, 100)] = 8
    """Places of a patch that have a motion and cells of their own."""
    cells: Annotated[int, whole(2, 200)] = 16
    """Cells of a patch that are simulated, the same number at every station."""
    youngs_modulus_mpa: Modulus | None = None
    """Of the contacts [MPa]; by default the softest that lowers g rms by at most 2 %, which is
    part of the error."""
    scenarios: Annotated[tuple[str, ...], Field(min_length=1)] | None = None
    """Labels of those that are run; by default all. What is found there is carried to other
    levels of the same layouts, within 3 dB, and the error of that is stated."""

    @property
    def run_s(self) -> float:
        """Length of a run [s]."""
        return self.settle_s + self.duration_s

    def mistakes(self) -> Iterator[Mistake]:
        """Yield cells that cannot be shared out evenly."""
        if self.cells % self.stations:
            yield Mistake(("cells",), f"must be a multiple of stations = {self.stations}")


class Damping(Model):
    """Where C_e and m_a come from; the PSDs are computed with each reading."""

    readings: Annotated[tuple[Reading, ...], Field(min_length=1)] | None = None
    """``stated``: every patch as ``dampers`` states it. The others are of all patches alike:
    ``dem`` the section ``coupon`` under single tones, ``table`` the key below, ``paper_…`` the
    paper's law. ``coupled``: panel and particles are integrated together; patches without a coupon
    are read as ``stated``. By default ``coupled`` where a scenario has a coupon, since sound is no
    sine; with ``level`` or ``tones``, which are of single tones, with diagonal modal
    damping, and without a coupon, ``stated`` in a study with ``dampers``, else ``dem``."""
    level: Level = Level()
    """The amplitude at which C_e is read."""
    table: Annotated[Path, file_in(DATA / "damping")] | None = None
    """CSV table of measured damping, for the reading ``table``."""
    interpolation: Interpolation | None = None
    """Between the rows of the table: log (by default) or linear."""
    coupled: Coupled = Coupled()
    """For the reading ``coupled``."""
    tones: Tones | None = None
    """By default nothing is run beside ``coupon.sweep``."""

    @model_validator(mode="before")
    @classmethod
    def _refuse_removed(cls, values: Any) -> Any:
        if isinstance(values, Mapping):
            readings = values.get("readings")
            items = list(readings) if isinstance(readings, list | tuple) else []
            says = f"is gone; '{COUPLED}', the default for sound, has taken its place"
            found = [
                Mistake(("readings", place), f"{name!r} {says}")
                for place, name in enumerate(items)
                if name in REMOVED
            ]
            if "random" in values:
                found.append(Mistake(("random",), f"{says}, with the keys of damping.coupled"))
            if "target" in values:
                says = "is gone, since its errors were too small; coupon.sweep is run whole, and "
                says += "damping.tones adds cases where scenarios read them"
                found.append(Mistake(("target",), says))
            if found:
                raise Mistakes(found)
        return values

    @property
    def is_of_tones(self) -> bool:
        """Whether a key says at which single tones coupons are shaken, or read."""
        return bool(self.tones or self.level != Level())

    def mistakes(self) -> Iterator[Mistake]:
        """Yield readings given more than once, and keys that lack their reading."""
        readings = self.readings or ()
        if len(set(readings)) != len(readings):
            yield Mistake(("readings",), "must not contain a reading more than once")
        if ("table" in readings) != (self.table is not None):
            yield Mistake(("table",), "required for the reading 'table', not allowed otherwise")
        if self.interpolation is not None and self.table is None:
            yield Mistake(("interpolation",), "only allowed with table")
