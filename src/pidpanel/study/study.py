"""A whole study: its sections, dampers, damping models and scenarios."""

import itertools
from collections.abc import Iterator, Mapping
from typing import Annotated, Any

from pydantic import BeforeValidator, Field, model_validator

from pidpanel.constants import ATLAS, BY_DAMPER
from pidpanel.paths import SECTION
from pidpanel.study import requirements
from pidpanel.study.base import StudyError, as_tuple
from pidpanel.study.base_motion import BaseMotion, sound_or_base
from pidpanel.study.core_cells import cells_of_core, differing_cells
from pidpanel.study.coupon import Coupon
from pidpanel.study.coupon_study import NAME_WORDS, CouponStudy, is_name
from pidpanel.study.dampers import Damper, is_massless_table
from pidpanel.study.damping import COUPLED, Damping, Level
from pidpanel.study.mistakes import Keys, Mistake, mistakes_of_names, not_among
from pidpanel.study.optimise import Optimise
from pidpanel.study.panel import Panel
from pidpanel.study.response import Measurement, Radiation, Response
from pidpanel.study.scenarios import Compared, Family, Filled, Filling, Layout, Scenario, items_of
from pidpanel.study.severity import Severity
from pidpanel.study.sound import SPEED, Sound
from pidpanel.study.surroundings import opposite, setting

BARE = "bare"  # the only damping model of a study without scenarios


class Study(CouponStudy):
    """All that a run of the whole workflow depends on."""

    dampers: Mapping[str, Damper] = {}
    """Dampers that can fill patches, by name. The section ``coupon`` is also a damper, ``coupon``.
    A damper that is in no scenario is not simulated."""
    damping: Damping = Damping()
    """Damping models of C_e and m_a."""
    panel: Panel
    """The panel."""
    base: BaseMotion | None = None
    """Motion of the supports on a shaker, computed in addition to sound or without it."""
    sound: Annotated[Sound | None, BeforeValidator(sound_or_base)] = Field(
        default=None, validate_default=True
    )
    """The sound field; required unless there is a section ``base``."""
    response: Response = Response()
    """Quantities computed for the panel in the sound."""
    scenarios: Mapping[str, Compared] = {}
    """Families of one patch, and layouts; none for a study of the bare panel."""
    optimise: Optimise | None = None
    """Search for layouts within a mass budget."""
    severity: Severity | None = None
    """Oscillator spectra, peaks in a duration and fatigue; none without this section."""
    measurements: Mapping[str, Measurement] = {}
    """Measured PSDs and transmissibilities to draw over computed ones, by name."""

    @model_validator(mode="before")
    @classmethod
    def _fill_core(cls, values: Any) -> Any:
        """Give cells without a width or a depth those of the core of a sandwich."""
        return cells_of_core(values)

    def mistakes(self) -> Iterator[Mistake]:
        yield from super().mistakes()
        too_many = [
            *mistakes_of_names("dampers", self.dampers),
            *mistakes_of_names("scenarios", self.scenarios),
        ]
        yield from too_many
        if too_many:
            return
        yield from self._mistakes_of_dampers()
        yield from self._mistakes_of_readings()
        yield from requirements.mistakes_of_severity(self)
        yield from requirements.mistakes_of_base(self)
        yield from requirements.mistakes_of_surroundings(self)
        mistakes = list(self.mistakes_of_scenarios())
        yield from mistakes
        if mistakes:
            return
        yield from requirements.mistakes_of_labels(self)
        yield from requirements.mistakes_of_optimise(self)
        yield from requirements.mistakes_of_atlas(self)
        yield from requirements.mistakes_of_measurements(self)
        labels = [scenario.label for scenario in self.all_scenarios()]
        for index, label in enumerate(self.response.maps):
            if label not in labels:
                yield Mistake(("response", "maps", index), f"must be one of {', '.join(labels)}")

    @property
    def acoustics(self) -> Sound:
        """The section ``sound``; `StudyError` in a study of base motion alone."""
        if self.sound is None:
            raise StudyError(f"{self.name}: sound: missing; this is a study of base motion alone")
        return self.sound

    @property
    def oaspl_db(self) -> float | None:
        """Overall level of the section ``sound`` [dB]; None without one, or for that of a table."""
        return None if self.sound is None else self.sound.oaspl_db

    @property
    def radiation(self) -> Radiation:
        """Sides with air on them; both of a panel with free edges."""
        is_free = self.sound is not None and self.sound.is_free
        return self.response.radiation or ("two_sides" if is_free else "none")

    @property
    def setting(self) -> str:
        """Where the panel hangs, and where the level of the sound was measured, in words."""
        return setting(self.acoustics, self.radiation)

    @property
    def opposite(self) -> "Study | None":
        """The study with the other surroundings; None where its field has none."""
        sections = opposite(self.acoustics, self.response)
        update = sections and dict(zip(("sound", "response"), sections, strict=True))
        return self.model_copy(update=update) if update else None

    @property
    def wave_speed(self) -> float:
        """Speed of sound [m/s]."""
        return SPEED if self.sound is None else self.sound.speed_m_s

    # ------------------------------------------------------------------------ dampers

    @property
    def all_dampers(self) -> Mapping[str, Damper]:
        """All dampers: the section ``coupon``, then those of ``dampers``."""
        section = {SECTION: Damper.model_construct(coupon=self.coupon)} if self.coupon else {}
        return {**section, **self.dampers}

    @property
    def used_dampers(self) -> tuple[str, ...]:
        """Names of the dampers used with a damping model of `BY_DAMPER`."""
        named = {filling.damper for filling in self.fillings}
        used = tuple(name for name in self.all_dampers if name in named)
        return used if set(BY_DAMPER) & set(self.readings) else ()

    @property
    def massless_dampers(self) -> dict[str | None, str]:
        """Dampers whose particles weigh nothing in the computation, and the key that changes it.

        None means the table of all patches.
        """
        if not self.response.damper_mass:
            return {}
        massless: dict[str | None, str] = {
            name: f"dampers.{name}.apparent_mass: particles"
            for name in self.used_dampers
            if self.all_dampers[name].is_massless
        }
        table = self.damping.table
        if table is not None and self.damping.apparent_mass is None and is_massless_table(table):
            massless[None] = "damping.apparent_mass: particles"
        return massless

    @property
    def differing_cells(self) -> list[str]:
        """Dampers whose cells are not those of the core, in words."""
        return differing_cells(self.panel.section, self.all_dampers)

    @property
    def stated_dampers(self) -> tuple[str, ...]:
        """Names of those that are read as the study states them; without ``stated`` no coupons."""
        if "stated" in self.readings:
            return self.used_dampers
        return tuple(name for name in self.used_dampers if self.all_dampers[name].coupon is None)

    @property
    def coupons(self) -> Mapping[str, Coupon]:
        """Coupons to simulate by the names of their dampers, that of the section first.

        A coupon that is only integrated together with the panel, or read from the atlas, needs no
        sweep.
        """
        without_sweep = {COUPLED, ATLAS} & set(self.readings) and "dem" not in self.readings
        stated = {} if without_sweep else super().coupons
        used = {name: self.all_dampers[name].coupon for name in self.stated_dampers}
        return {**stated, **{name: value for name, value in used.items() if value is not None}}

    @property
    def atlas_coupons(self) -> Mapping[str, Coupon]:
        """Coupons that are read from the atlas, by the names of their dampers."""
        if ATLAS not in self.readings:
            return {}
        placed = self.optimise.dampers or tuple(self.all_dampers) if self.optimise else ()
        coupons = {name: self.all_dampers[name].coupon for name in self.all_dampers
                   if name in (*self.used_dampers, *placed)}  # fmt: skip
        return {name: coupon for name, coupon in coupons.items() if coupon is not None}

    @property
    def prior_coupons(self) -> Mapping[str, Coupon]:
        """Coupons whose surfaces start from the atlas, by the names of their dampers."""
        names = self.surfaces if self.damping.prior == ATLAS else ()
        return {name: self.coupons[name] for name in names}

    @property
    def surfaces(self) -> tuple[str, ...]:
        """Names of the coupons whose cases become a surface of C_e and m_a that is read."""
        read = set(self.stated_dampers) | ({SECTION} if "dem" in self.readings else set())
        return tuple(name for name in self.coupons if name in read)

    @property
    def readings(self) -> tuple[str, ...]:
        """Readings of the damping; ``bare`` alone for a bare panel."""
        if not self.scenarios:
            return (BARE,)
        if self.damping.readings is not None:
            return tuple(self.damping.readings)
        # a level is that of single tones
        is_full, is_of_tones = self.response.modal_damping == "full", self.damping.level != Level()
        if self.has_filled_coupon and is_full and not is_of_tones:
            return (COUPLED,)
        return ("stated",) if self.dampers else ("dem",)

    @property
    def has_filled_coupon(self) -> bool:
        """Whether a scenario names a damper with a coupon."""
        fillings = (filled for entry in self.scenarios.values() for *_, filled in entry.fillings())
        dampers = (self.all_dampers.get(self._damper_name(filled) or "") for filled in fillings)
        return any(damper is not None and damper.coupon is not None for damper in dampers)

    @property
    def is_coupled(self) -> bool:
        """Whether panel and particles are integrated together."""
        return COUPLED in self.readings

    def coupled_scenarios(self) -> tuple[Scenario, ...]:
        """Return the scenarios with a coupon, where they are integrated together with the panel."""
        return tuple(s for s in self.all_scenarios() if self.is_coupled and self.beds_of(s))

    def beds_of(self, scenario: Scenario) -> tuple[tuple[Filling, Coupon, float], ...]:
        """Return the filled patches of a scenario that have a coupon, with it and its fill."""
        return tuple(
            (filling, damper.coupon, filling.fill_fraction)
            for filling in scenario.fillings
            if (damper := self.damper_of(filling)) is not None
            and damper.coupon is not None
            and filling.fill_fraction is not None
        )

    def _mistakes_of_dampers(self) -> Iterator[Mistake]:
        for name in self.dampers:
            if not is_name(name):
                yield Mistake(("dampers", name), f"must have a name of {NAME_WORDS}")
            if name == SECTION and self.coupon is not None:
                yield Mistake(("dampers", name), "must have another name than the section coupon")

    def _mistakes_of_readings(self) -> Iterator[Mistake]:
        yield from self.coupon.mistakes_with_panel() if self.coupon else ()
        if "dem" in self.readings and self.coupon is None:
            if self.damping.readings is None:
                message = "missing; scenarios need a section coupon, dampers, or damping.readings"
                yield Mistake(("dampers",), message)
            else:
                yield Mistake(("coupon",), "missing; required for the damping model 'dem'")
        if "stated" in self.readings and not self.all_dampers:
            yield Mistake(("dampers",), "missing; required for the damping model 'stated'")
        if "coupled" in self.damping.model_fields_set and not self.is_coupled:
            message = f"only allowed with the damping model '{COUPLED}'"
            yield Mistake(("damping", "coupled"), message)
        yield from requirements.mistakes_of_coupled(self)

    # ---------------------------------------------------------------------- scenarios

    def mistakes_of_scenarios(self) -> Iterator[Mistake]:
        """Yield patches and dampers that are not there, and fills that a damper does not have."""
        for name, compared in self.scenarios.items():
            for way, patches, filled in compared.fillings():
                for keys, patch in patches:
                    yield from self._mistakes_of_patch(("scenarios", name, *way, *keys), patch)
                for mistake in self._mistakes_of_filling(filled):
                    yield mistake.prefix("scenarios", name, *way)

    def _mistakes_of_patch(self, keys: Keys, patch: str) -> Iterator[Mistake]:
        patches = list(self.panel.patches)
        if not patches:
            yield Mistake(keys, "there are no patches")
        elif patch not in patches:
            yield Mistake(keys, not_among("panel.patches", patch, patches))

    def _mistakes_of_filling(self, filled: Family | Filled) -> Iterator[Mistake]:
        """Yield a damper that is unknown or missing, and fills that its coupon does not have."""
        names = list(self.all_dampers)
        if filled.damper is not None and filled.damper not in names:
            message = (
                not_among("dampers", filled.damper, names) if names else "there are no dampers"
            )
            yield Mistake(("damper",), message)
        elif filled.damper is None and len(names) > 1:
            yield Mistake(("damper",), f"missing; must be one of dampers: {', '.join(names)}")
        else:
            yield from self._mistakes_of_fill(filled, self._damper_name(filled))

    def _mistakes_of_fill(self, filled: Family | Filled, damper: str | None) -> Iterator[Mistake]:
        needed = next(self._needs_fill(damper), None)
        if needed and filled.fill_fraction is None:
            yield Mistake(("fill_fraction",), f"missing; required for {needed}")
        for keys, fill in items_of("fill_fraction", filled.fill_fraction):
            for way, coupon in self._coupons_read(damper):
                low, high = (f(coupon.sweep.fill_fraction) for f in (min, max))
                if fill is not None and not low <= fill <= high:
                    yield Mistake(keys, f"must be in the range of {way}.sweep, {low:g} to {high:g}")
        if filled.fill_fraction is not None and damper is not None and not needed:
            kind = self.all_dampers[damper].kind
            if kind != "table":  # its columns decide
                message = (
                    f"not allowed: the {kind} of {damper} does not depend on the fill fraction"
                )
                yield Mistake(("fill_fraction",), message)

    def fills(self, damper: str | None) -> Iterator[tuple[Keys, float]]:
        """Yield the fills of a damper, or of all, with the ways to them."""
        for name, compared in self.scenarios.items():
            for way, _, filled in compared.fillings():
                if damper in (None, self._damper_name(filled)):
                    for keys, fill in items_of("fill_fraction", filled.fill_fraction):
                        if fill is not None:
                            yield ("scenarios", name, *way, *keys), fill

    def _damper_name(self, filled: Family | Filled) -> str | None:
        """Return the damper that is meant: the one that is named, or the only one."""
        return filled.damper or next(iter(self.all_dampers), None)

    def _needs_fill(self, damper: str | None) -> Iterator[str]:
        """Yield what of a patch with a damper asks for its fill."""
        for reading in self.readings:
            if reading not in BY_DAMPER:
                yield f"the damping model '{reading}'"
            elif damper is not None and self.all_dampers[damper].is_of_a_fill:
                yield f"the {self.all_dampers[damper].kind} of {damper}"

    def _coupons_read(self, damper: str | None) -> Iterator[tuple[str, Coupon]]:
        """Yield the coupons from which a patch with a damper is read, with the ways to them."""
        is_stated, named = "stated" in self.readings, self.dampers.get(damper or "")
        if self.coupon is not None and ("dem" in self.readings or (is_stated and named is None)):
            yield "coupon", self.coupon
        if is_stated and named is not None and named.coupon is not None:
            yield f"dampers.{damper}.coupon", named.coupon

    @property
    def families(self) -> Mapping[str, Family]:
        """The families among the scenarios."""
        return {name: entry for name, entry in self.scenarios.items() if isinstance(entry, Family)}

    @property
    def layouts(self) -> Mapping[str, Layout]:
        """The explicit layouts among the scenarios."""
        return {name: entry for name, entry in self.scenarios.items() if isinstance(entry, Layout)}

    def family_scenarios(self, name: str) -> tuple[Scenario, ...]:
        """Return the scenarios of one family, in the order of its list; one for a layout."""
        compared = self.scenarios[name]
        level = self.oaspl_db if compared.oaspl_db is None else compared.oaspl_db
        if isinstance(compared, Layout):
            fillings = tuple(
                self._filling(patch, filled, filled.fill_fraction)
                for patch, filled in compared.layout.items()
            )
            return (Scenario(label=name, fillings=fillings, oaspl_db=level),)
        patches, fills = as_tuple(compared.patch), as_tuple(compared.fill_fraction)
        has_dampers = len(self.all_dampers) > 1
        return tuple(
            Scenario.of_patch(self._filling(patch, compared, fill), level, has_dampers=has_dampers)
            for patch, fill, level in itertools.product(patches, fills, as_tuple(level))
        )

    def _filling(self, patch: str, filled: Family | Filled, fill: float | None) -> Filling:
        return Filling(patch=patch, damper=self._damper_name(filled), fill_fraction=fill)

    def all_scenarios(self) -> tuple[Scenario, ...]:
        """Return every scenario once, the bare panel at each level first."""
        scenarios = [s for name in self.scenarios for s in self.family_scenarios(name)]
        if not scenarios:
            return (Scenario.bare_at(self.oaspl_db),)
        return tuple(dict.fromkeys([s.bare for s in scenarios] + scenarios))

    @property
    def fillings(self) -> tuple[Filling, ...]:
        """The filled patches of all scenarios."""
        return tuple(f for scenario in self.all_scenarios() for f in scenario.fillings)

    def damper_of(self, filling: Filling) -> Damper | None:
        """Return the damper of a filled patch; None where it has none."""
        return self.all_dampers.get(filling.damper or "")

    def mapped_scenarios(self) -> tuple[Scenario, ...]:
        """Return the scenarios of ``response.maps``."""
        labels = self.response.maps or (self.all_scenarios()[0].label,)
        return tuple(s for s in self.all_scenarios() if s.label in labels)
