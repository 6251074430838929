"""A whole study: its sections, dampers, damping models and scenarios."""

import itertools
import re
from collections.abc import Iterator, Mapping
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field, model_validator

from pidpanel.study import requirements
from pidpanel.study.base import StudyError, Text, Vector, as_tuple
from pidpanel.study.base_motion import BaseMotion, sound_or_base
from pidpanel.study.claims import Claim
from pidpanel.study.core_cells import cells_of_core, differing_cells
from pidpanel.study.coupon import Coupon
from pidpanel.study.coupon_study import CHARACTERS, DAMPER_NAME, CouponStudy
from pidpanel.study.dampers import (
    BEDS,
    COUPLED,
    TONES,
    AnyDamper,
    BedDamper,
    ModelName,
    with_likes,
    with_models,
)
from pidpanel.study.damping import Damping
from pidpanel.study.mistakes import Keys, Mistake, mistakes_of_names
from pidpanel.study.optimise import Optimise
from pidpanel.study.response import Energy, Measurement, Radiation, Response, mistakes_of_energy
from pidpanel.study.scenarios import Compared, Family, Filling, Layout, Scenario, level_suffix
from pidpanel.study.severity import AccelerationLimit, Severity
from pidpanel.study.sound import SPEED, Sound
from pidpanel.study.stated_dampers import DamperSection, ModelText
from pidpanel.study.structure import PanelOrStructure, with_structure
from pidpanel.study.surroundings import opposite, setting
from pidpanel.study.uncertain import Margin, Spread, mistakes_of_margin
from pidpanel.study.update import Update


class Study(CouponStudy):
    """All that a run of the whole workflow depends on."""

    removed_keys: ClassVar[Mapping[str, str]] = {
        "coupon": "only in a study of the coupon alone; with a panel its keys are those of a "
        "damper: dampers: {acrylic: {cell: …, particles: …, sweep: …, model: tones}}, or without "
        "sweep and with model: coupled or atlas"
    }

    dampers: Mapping[str, AnyDamper] = {}
    """Dampers that can fill patches, by name: what they are, and how their damping is known. One
    that is in no scenario is not simulated."""
    damping: Damping = Damping()
    """The motion at which damping is evaluated, and settings of coupled runs."""
    panel: PanelOrStructure
    """The panel; required unless there is a section ``structure``."""
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
    energy: Energy | None = None
    """Statistical energy of a flat panel in a diffuse field, above the frequencies of the
    response; none without this section."""
    severity: Severity | None = None
    """Oscillator spectra, peaks in a duration and fatigue; none without this section."""
    limits: Mapping[Text, AccelerationLimit] = {}
    """Largest accelerations allowed at response points, by name, with margins and verdicts."""
    uncertain: Mapping[Text, Spread] = {}
    """Spreads of inputs by their keys joined with dots, such as ``panel.damping_ratio``."""
    margin: Margin = Margin()
    """What is judged with the spreads of ``uncertain``."""
    update: Update | None = None
    """Results of tests, with which the answer of ``uncertain`` is updated."""
    measurements: Mapping[str, Measurement] = {}
    """Measured PSDs and transmissibilities to draw over computed ones, by name."""
    claims: tuple[Claim, ...] = ()
    """Statements of a publication that the report judges by the results under sound."""

    @model_validator(mode="before")
    @classmethod
    def _complete_dampers(cls, values: Any) -> Any:
        """Give dampers what they have in common with others, the cells of a core, and a model."""
        values = with_structure(values)
        dampers = values.get("dampers") if isinstance(values, Mapping) else None
        if not isinstance(dampers, Mapping):
            return values
        return cells_of_core({**values, "dampers": with_models(with_likes(dampers), values)})

    def mistakes(self) -> Iterator[Mistake]:
        yield from super().mistakes()
        mistakes = [
            *mistakes_of_names("dampers", self.dampers),
            *mistakes_of_names("scenarios", self.scenarios),
        ]
        if mistakes:
            yield from mistakes
            return
        for name in self.dampers:
            if not re.fullmatch(DAMPER_NAME, name):
                message = f"{CHARACTERS}, with blanks between them, the first a letter or a digit"
                yield Mistake(("dampers", name), f"must have a name of {message}")
        yield from requirements.mistakes_of_coupled(self)
        yield from mistakes_of_energy(self)
        yield from requirements.mistakes_of_severity(self)
        yield from requirements.mistakes_of_limits(self)
        yield from requirements.mistakes_of_base(self)
        yield from requirements.mistakes_of_surroundings(self)
        if mistakes := list(requirements.mistakes_of_scenarios(self)):
            yield from mistakes
            return
        yield from requirements.mistakes_of_labels(self)
        if self.optimise is not None:
            mistakes = list(requirements.mistakes_of_optimise(self.optimise, self))
            yield from (mistake.prefix("optimise") for mistake in mistakes)
        yield from requirements.mistakes_of_atlas(self)
        yield from requirements.mistakes_of_steady_acceleration(self)
        yield from requirements.mistakes_of_tolerances(self)
        yield from requirements.mistakes_of_measurements(self)
        yield from requirements.mistakes_of_claims(self)
        yield from mistakes_of_margin(self)

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
    def oaspl_levels(self) -> tuple[float | None, ...]:
        """Levels of scenarios that state none [dB]: all of ``sound.levels``, or `oaspl_db`."""
        return (tuple(self.sound.named_levels) if self.sound else ()) or (self.oaspl_db,)

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
        update = opposite(self.acoustics, self.response)
        return self.model_copy(update=update) if update else None

    @property
    def wave_speed(self) -> float:
        """Speed of sound [m/s]."""
        return SPEED if self.sound is None else self.sound.speed_m_s

    # ------------------------------------------------------------------------ dampers

    @property
    def placed_dampers(self) -> tuple[str, ...]:
        """Names of the dampers that a search may place."""
        return () if self.optimise is None else self.optimise.dampers or tuple(self.dampers)

    @property
    def scenario_dampers(self) -> tuple[str, ...]:
        """Names of the dampers that a scenario has."""
        parts = (part for entry in self.scenarios.values() for part in entry.parts())
        named = {self.name_of(damper) for part in parts for _, damper in part.dampers}
        return tuple(name for name in self.dampers if name in named)

    @property
    def used_dampers(self) -> tuple[str, ...]:
        """Names of the dampers that a scenario has, or a search may place."""
        used = {*self.scenario_dampers, *self.placed_dampers}
        return tuple(name for name in self.dampers if name in used)

    def beds(self, *models: ModelName) -> dict[str, BedDamper]:
        """Return the used dampers of particles with one of some damping models."""
        dampers = {name: self.dampers[name] for name in self.used_dampers}
        return {
            name: damper
            for name, damper in dampers.items()
            if isinstance(damper, BedDamper) and damper.model in models
        }

    @property
    def coupons(self) -> Mapping[str, Coupon]:
        """Coupons to simulate by the names of their dampers."""
        return self.beds(TONES)

    @property
    def massless_dampers(self) -> dict[str, str]:
        """Dampers whose particles weigh nothing in the computation, and the key that changes it."""
        if not self.response.damper_mass:
            return {}
        return {
            name: f"dampers.{name}.apparent_mass: particles"
            for name in self.used_dampers
            if self.dampers[name].is_massless
        }

    @property
    def differing_cells(self) -> list[str]:
        """Dampers whose cells are not those of the core, in words."""
        return differing_cells(self.panel.section, self.dampers)

    @property
    def is_coupled(self) -> bool:
        """Whether panel and particles are integrated together."""
        return bool(set(self.beds(COUPLED)) & set(self.scenario_dampers))

    def coupled_scenarios(self) -> tuple[Scenario, ...]:
        """Return the scenarios that are integrated together with the panel."""
        return tuple(s for s in self.all_scenarios() if self.is_coupled_scenario(s))

    def is_coupled_scenario(self, scenario: Scenario) -> bool:
        """Return whether a scenario is integrated together with the panel."""
        return any(text.rank == BEDS[COUPLED].rank for text in self.model_texts(scenario))

    def model_texts(self, scenario: Scenario) -> list[ModelText]:
        """Return the damping models of a scenario, each once."""
        texts = [self.damper_of(filling).text for filling in scenario.fillings.values()]
        return list(dict.fromkeys(texts))

    def alternatives(self, scenario: Scenario) -> list[Scenario]:
        """Return the scenarios that differ from one in the damping model alone."""
        beds = self._beds_of(scenario)
        return [
            rival
            for rival in self.all_scenarios()
            if rival.label != scenario.label
            and (rival.oaspl_db, rival.steady_acceleration_g, rival.patches)
            == (scenario.oaspl_db, scenario.steady_acceleration_g, scenario.patches)
            and not rival.is_bare
            and all(
                first == second and (bed == other_bed or None in (bed, other_bed))
                for (first, bed), (second, other_bed) in zip(
                    beds, self._beds_of(rival), strict=True
                )
            )
        ]

    def _beds_of(self, scenario: Scenario) -> list[tuple[float | None, Any]]:
        """Return fill and bed of each patch; no bed for a damping model of any particles."""
        beds = []
        for filling in scenario.fillings.values():
            damper = self.damper_of(filling)
            if damper.like is not None and not isinstance(damper, BedDamper):
                damper = self.dampers[damper.like]
            beds.append((filling.fill_fraction, damper.bed))
        return beds

    @property
    def has_verdict(self) -> bool:
        """Whether coupled runs can be compared with other damping models of the same beds."""
        compared = (self.alternatives(s) for s in self.coupled_scenarios())
        rivals = [rival for alike in compared for rival in alike]
        return self.sound is not None and not all(map(self.is_coupled_scenario, rivals))

    def is_main(self, scenario: Scenario) -> bool:
        """Return whether no other damping model answers before that of a scenario."""
        rank = self._rank(scenario)
        return all(self._rank(rival) >= rank for rival in self.alternatives(scenario))

    def _rank(self, scenario: Scenario) -> int:
        return max((text.rank for text in self.model_texts(scenario)), default=0)

    # ---------------------------------------------------------------------- scenarios

    def fills(self, name: str) -> Iterator[tuple[Keys, float]]:
        """Yield the fills of a damper, with the ways to them."""
        for entry, compared in self.scenarios.items():
            for part in compared.parts():
                if name in [self.name_of(damper) for _, damper in part.dampers]:
                    for keys, fill in part.fills:
                        if fill is not None:
                            yield ("scenarios", entry, *part.way, *keys), fill

    def name_of(self, damper: str | None) -> str:
        """Return the damper that is meant: the one that is named, or the only one."""
        return damper or next(iter(self.dampers), "")

    @property
    def families(self) -> Mapping[str, Family]:
        """The families among the scenarios."""
        return {name: entry for name, entry in self.scenarios.items() if isinstance(entry, Family)}

    @property
    def layouts(self) -> Mapping[str, Layout]:
        """The explicit layouts among the scenarios."""
        return {name: entry for name, entry in self.scenarios.items() if isinstance(entry, Layout)}

    def family_scenarios(self, name: str) -> tuple[Scenario, ...]:
        """Return the scenarios of one family, in the order of its lists, or of a layout."""
        compared, several = self.scenarios[name], len(self.dampers) > 1
        steady = compared.steady_acceleration_g
        if isinstance(compared, Layout):
            fillings = {
                patch: filling.model_copy(update={"damper": self.name_of(filling.damper)})
                for patch, filling in compared.layout.items()
            }
            levels = (compared.oaspl_db,) if compared.oaspl_db else self.oaspl_levels
            suffixes = map(level_suffix, levels if len(levels) > 1 else [None])
            return tuple(
                Scenario(label=f"{name}{suffix}", fillings=fillings, oaspl_db=level,
                         steady_acceleration_g=steady, has_dampers=several)
                for suffix, level in zip(suffixes, levels, strict=True)
            )  # fmt: skip
        levels = self.oaspl_levels if compared.is_single else (self.oaspl_db,)
        levels = as_tuple(compared.oaspl_db) if compared.oaspl_db else levels
        combinations = itertools.product(
            as_tuple(compared.damper), as_tuple(compared.patch),
            as_tuple(compared.fill_fraction), levels,
        )  # fmt: skip
        scenarios = []
        for damper, patch, fill, level in combinations:
            filling = Filling(damper=self.name_of(damper), fill_fraction=fill)
            scenarios.append(Scenario.of_patch(patch, filling, level, steady, has_dampers=several))
        return tuple(scenarios)

    def all_scenarios(self) -> tuple[Scenario, ...]:
        """Return every scenario once, the bare panel at each level first."""
        scenarios = [s for name in self.scenarios for s in self.family_scenarios(name)]
        if not scenarios:
            return tuple(map(Scenario.bare_at, self.oaspl_levels))
        every = [*(s.bare for s in scenarios), *scenarios]
        return tuple({scenario.label: scenario for scenario in every}.values())

    @property
    def fillings(self) -> tuple[Filling, ...]:
        """What fills the patches of all scenarios."""
        return tuple(f for scenario in self.all_scenarios() for f in scenario.fillings.values())

    def damper_of(self, filling: Filling) -> DamperSection:
        """Return the damper of a patch."""
        return self.dampers[self.name_of(filling.damper)]

    def damper_in(self, scenario: Scenario, patch: str) -> DamperSection:
        """Return the damper of a patch under the steady acceleration of a scenario."""
        damper = self.damper_of(scenario.fillings[patch])
        damper = damper.with_steady_acceleration(scenario.steady_acceleration_g)
        normal = self.patch_normal(patch)
        return damper if normal is None else damper.in_frame(normal)

    def damper_name(self, scenario: Scenario, patch: str) -> str:
        """Return the damper of a patch; patches of a structure have their own gravity."""
        name = scenario.damper_name(patch)
        return name if self.patch_normal(patch) is None else f"{name} on {patch}"

    def patch_normal(self, patch: str) -> Vector | None:
        """Return the normal of a patch of a structure; None on a panel, where it is z."""
        return getattr(self.panel.patches.get(patch), "normal", None)

    def gravity_angles(self, patch: str) -> list[float]:
        """Return the angles of gravity to the motion of the beds on a patch [°]."""
        angles = {
            round(damper.gravity_angle_deg, 1)
            for scenario in self.all_scenarios()
            if patch in scenario.fillings
            and isinstance(damper := self.damper_in(scenario, patch), BedDamper)
        }
        return sorted(angles)

    def mapped_scenarios(self) -> tuple[Scenario, ...]:
        """Return the scenarios of ``response.maps``."""
        labels = self.response.maps or (self.all_scenarios()[0].label,)
        return tuple(s for s in self.all_scenarios() if s.label in labels)

    def damper_masses(self, *, with_rows: bool = False) -> dict[str, float]:
        """Return about the heaviest damper of each patch that a scenario fills [kg/m²].

        The basis follows the panel with these masses, whatever the fills of its scenarios; 0 where
        the mass is not known before the run, as of a table. ``with_rows`` adds m_a in the rows of
        tables, which the mesh resolves.
        """
        highest = self.response.frequency_hz[1]
        masses: dict[str, float] = {}
        for scenario in self.all_scenarios():
            for patch, filling in scenario.fillings.items():
                damper, mass = self.damper_of(filling), 0.0
                if self.response.damper_mass:
                    mass = damper.largest_mass_per_area(highest)
                    if with_rows:
                        mass = max(mass, damper.mass_of_rows(filling.fill_fraction))
                masses[patch] = max(masses.get(patch, 0.0), mass)
        return masses
