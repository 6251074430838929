"""The section ``dampers`` of a study: what fills patches, and how its damping is known.

A class for each kind of damper. `pidpanel.damping.from_study` makes the damper of it.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar, Literal, Self

from pydantic import Discriminator, Tag, TypeAdapter, ValidationError

from pidpanel.constants import ATLAS
from pidpanel.study.base import Acceleration, Vector
from pidpanel.study.choice import TAG
from pidpanel.study.coupon import Coupon
from pidpanel.study.damping import Level
from pidpanel.study.mistakes import Keys, Mistake, Mistakes, not_among
from pidpanel.study.stated_dampers import (
    ConstantSection,
    DamperSection,
    ImpedanceDamper,
    LawDamper,
    LossFactorDamper,
    ModelText,
    TableDamper,
)

ModelName = Literal["coupled", "atlas", "tones"]
Prior = Literal["closed_form", "atlas"]

COUPLED: ModelName = "coupled"  # damping from panel and particles in one time integration
TONES: ModelName = "tones"  # damping from simulated single tones

BEDS: Mapping[ModelName, ModelText] = {
    COUPLED: ModelText("Panel and particles together", "coupled runs of this study", 0),
    TONES: ModelText("Single tones", "simulated coupons under single tones", 2),
    "atlas": ModelText("Atlas of particle beds", "atlas of particle beds", 3),
}


class BedDamper(DamperSection, Coupon):
    """Particles in cells, with one of three damping models.

    ``coupled`` integrates panel and particles together. ``atlas`` takes C_e and m_a from a table of
    simulated beds, without LIGGGHTS. ``tones`` simulates a coupon under the single tones of
    ``sweep``.
    """

    kind = "particles"
    removed_keys: ClassVar[Mapping[str, str]] = {
        "coupon": "was removed; its keys are those of the damper: {cell: …, particles: …, "
        "sweep: …, model: tones}, or without sweep and with model: coupled or atlas",
        **dict.fromkeys(("vary", "cases", "measured"), "only in a study of the coupon alone"),
    }

    model: ModelName = COUPLED
    """Damping model: ``coupled``, ``atlas`` or ``tones``. The default is ``coupled``, because sound
    is broadband; with ``damping.level``, which is for single tones, or diagonal modal damping it is
    ``tones``."""
    prior: Prior = "closed_form"
    """What the surface of ``tones`` starts from: closed forms, or the atlas of particle beds, with
    which fewer cases give the same uncertainty."""

    @property
    def text(self) -> ModelText:
        """Title and source of its damping model."""
        return BEDS[self.model]

    @property
    def bed(self) -> Any:
        """Cell, particles and gravity."""
        names = {"cell", "particles", "walls"}
        return {
            **self.model_dump(include=names, exclude={"cell": {"count"}}),
            "gravity": self.apparent_gravity_g,
        }

    def with_steady_acceleration(self, acceleration_g: Vector | None) -> Self:
        """Return the bed under a steady acceleration [g]; None for its own."""
        if acceleration_g is None:
            return self
        return self.model_copy(update={"steady_acceleration_g": acceleration_g})

    def in_frame(self, normal: Vector) -> Self:
        """Return the bed with gravity in the frame of a patch with a normal (x, y, z).

        z is then along the normal; that of a simulated coupon is stated in its own frame.
        """
        if self.model == TONES:
            return self
        total, size = self.apparent_gravity_g, math.hypot(*normal)
        along = sum(g * n for g, n in zip(total, normal, strict=True)) / size
        across = math.sqrt(max(math.hypot(*total) ** 2 - along**2, 0.0))
        across = across if across > 1e-6 * math.hypot(*total) else 0.0
        return self.model_copy(
            update={
                "gravity_g": math.hypot(along, across),
                "gravity_direction": (across, 0.0, along) if across or along else (0.0, 0.0, -1.0),
                "steady_acceleration_g": None,
            }
        )

    @property
    def is_of_atlas(self) -> bool:
        """Whether the atlas is needed for its damping."""
        return self.model == ATLAS or (self.model == TONES and self.prior == ATLAS)

    def mistakes(self) -> Iterator[Mistake]:
        if "particles" not in self.model_fields_set:
            yield Mistake((), f"must have one of {', '.join((*STATED, 'particles', 'like'))}")
            return
        yield from Coupon.mistakes(self)

    def largest_mass_per_area(self, frequency: float) -> float:
        """Return the mass of the particles at the highest fill [kg/m²]."""
        return self.bed_mass_per_area


Stated = LawDamper | TableDamper | ImpedanceDamper | ConstantSection | LossFactorDamper
STATED = ("law", "table", "impedance", "equivalent_damping_n_s_m3", "loss_factor")


def _kind(values: Any) -> str:
    """Return which kind of damper a mapping is: particles where no other is stated."""
    keys: Any = values if isinstance(values, Mapping) else getattr(values, "kind", "").split()
    return f"{TAG}{next((key for key in STATED if key in keys), 'bed')}"


AnyDamper = Annotated[
    Annotated[BedDamper, Tag(f"{TAG}bed")]
    | Annotated[LawDamper, Tag(f"{TAG}law")]
    | Annotated[TableDamper, Tag(f"{TAG}table")]
    | Annotated[ImpedanceDamper, Tag(f"{TAG}impedance")]
    | Annotated[ConstantSection, Tag(f"{TAG}equivalent_damping_n_s_m3")]
    | Annotated[LossFactorDamper, Tag(f"{TAG}loss_factor")],
    Discriminator(_kind),
]


def with_likes(dampers: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of dampers, each ``like`` another with that one's keys.

    Sections such as ``particles`` are merged key by key. One that states another kind, such as a
    table, takes nothing: it is another damping model of the same particles.
    """
    return {name: _with_like(name, dampers, ()) for name in dampers}


def _with_like(name: str, dampers: Mapping[str, Any], above: tuple[str, ...]) -> Any:
    values = dampers[name]
    like = values.get("like") if isinstance(values, Mapping) else None
    if not isinstance(like, str):
        return values
    keys: Keys = ("dampers", name, "like")
    if like not in dampers or like == name:
        names = [other for other in dampers if other != name]
        raise Mistakes([Mistake(keys, not_among("dampers", like, names))])
    if like in above:
        raise Mistakes([Mistake(keys, f"leads back to {name}")])
    base = _with_like(like, dampers, (*above, name))
    if not isinstance(base, Mapping) or any(key in values for key in STATED):
        return values
    merged = {
        key: {**base[key], **value}
        if isinstance(value, Mapping) and isinstance(base.get(key), Mapping)
        else value
        for key, value in values.items()
    }
    return {**base, **merged}


def with_models(dampers: Mapping[str, Any], study: Mapping[str, Any]) -> dict[str, Any]:
    """Return the values of dampers with the damping model and steady acceleration of the study.

    The model of those that state none is ``tones`` where a level is stated, which is one of single
    tones, or modal damping is diagonal; else `COUPLED`.
    """
    damping, response = study.get("damping"), study.get("response")
    sections = [study.get(key) for key in ("sound", "base")]
    steady = [s["steady_acceleration_g"] for s in sections
              if isinstance(s, Mapping) and _is_vector(s.get("steady_acceleration_g"))]  # fmt: skip
    common = {"steady_acceleration_g": steady[0]} if steady else {}
    level = damping.get("level") if isinstance(damping, Mapping) else None
    is_diagonal = isinstance(response, Mapping) and response.get("modal_damping") == "diagonal"
    model = TONES if is_diagonal or Level.is_stated(level) else COUPLED
    return {
        name: values
        if not isinstance(values, Mapping) or "particles" not in values
        else {"model": model, **common, **values}
        for name, values in dampers.items()
    }


def _is_vector(value: Any) -> bool:
    """Return whether a value is a steady acceleration; its section reports what it is not."""
    try:
        TypeAdapter(Acceleration).validate_python(value)
    except ValidationError:
        return False
    return True
