"""Requirements between the sections of a study, and of the atlas of a coupon (docs/atlas.md)."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

from pidpanel.study.dampers import BEDS, COUPLED, TONES, BedDamper
from pidpanel.study.mistakes import Keys, Mistake, mistakes_of_names, not_among
from pidpanel.study.optimise import LEAST_BAND, Optimise
from pidpanel.study.particles import Mono
from pidpanel.study.scenarios import Layout, Part, Scenario, vector_text
from pidpanel.study.severity import LEAST_CYCLES
from pidpanel.study.stated_number import error_of
from pidpanel.study.structure import Structure

if TYPE_CHECKING:
    from pidpanel.study.coupon import Coupon
    from pidpanel.study.study import Study

# Lines of a record, 1/T apart, in the range of the response: their scatter is the error of C_e.
FEWEST_LINES = 10

# Periods of the lowest frequency in a record: both halves then resolve a third octave there.
FEWEST_PERIODS = 10


LEAST_GAP = 0.1  # distance of a wall over the thickness of the panel


def mistakes_of_point(study: Study, name: str, keys: Keys) -> Iterator[Mistake]:
    """Yield a name of no response point."""
    if name not in study.panel.points:
        yield Mistake(keys, not_among("panel.points", name, list(study.panel.points)))


def mistakes_of_base(study: Study) -> Iterator[Mistake]:
    """Yield what base motion does not go together with."""
    if study.base is None:
        return
    if study.sound is None:
        yield from _mistakes_without_sound(study)
    if study.is_coupled and study.sound is not None:
        message = (
            "not allowed with a section sound and dampers with model: coupled, whose runs are "
        )
        message += "then under sound; put sound and base in two studies, or state model: atlas or "
        yield Mistake(("base",), f"{message}tones")
    elif study.is_coupled and study.base.random is None:
        yield Mistake(("base", "random"), "missing; required for dampers with model: coupled")
    elif study.base.sine is not None and study.is_coupled:
        if set(study.scenario_dampers) <= set(study.beds(COUPLED)):
            message = "needs a scenario whose damper has model: atlas or tones, or a table"
            yield Mistake(("base", "sine"), message)
    if study.damping.level.by == "element":
        yield Mistake(("damping", "level", "by"), "must be patch with a section base")
    high, sine = study.response.frequency_hz[1], study.base.sine
    if sine is not None and sine.frequency_hz[1] > high:
        message = f"must be at most the highest of response.frequency_hz, {high:g}"
        yield Mistake(("base", "sine", "frequency_hz", 1), message)
    for name in study.base.notching.points if study.base.notching else ():
        yield from mistakes_of_point(study, name, ("base", "notching", "points", name))
    if isinstance(study.panel, Structure):
        yield from _mistakes_of_moved_structure(study.panel)
        return
    if study.base.direction is not None:
        message = "only allowed with a structure; a panel moves along its normal"
        yield Mistake(("base", "direction"), message)
    supports = study.panel.support_input
    if supports.outline == supports.holes == "free" and not (supports.edges or supports.points):
        yield Mistake(("panel", "supports"), "a free panel has no supports that base moves")


def _mistakes_of_moved_structure(structure: Structure) -> Iterator[Mistake]:
    """Yield what base motion of a shell needs: something that holds it."""
    shell = structure.shell  # files of modes are read later
    if shell and not shell.supports and all(foot.kind == "free" for foot in shell.feet.values()):
        message = "a free structure has no supports that base moves"
        yield Mistake(("panel", "shell", "supports"), message)


def _mistakes_without_sound(study: Study) -> Iterator[Mistake]:
    """Yield what is only computed under sound."""
    response = study.response
    asked: dict[Keys, bool] = {
        ("energy",): study.energy is not None,
        ("severity",): study.severity is not None,
        ("response", "maps"): bool(response.maps),
        ("response", "radiation"): response.radiation not in (None, "none"),
    }
    for name, compared in study.scenarios.items():
        asked["scenarios", name, "oaspl_db"] = compared.oaspl_db is not None
    for keys, is_asked in asked.items():
        if is_asked:
            yield Mistake(keys, "only allowed with a section sound")


def mistakes_of_surroundings(study: Study) -> Iterator[Mistake]:
    """Yield what a panel with free edges does not go together with."""
    sound, response = study.sound, study.response
    if sound is None or not sound.is_free:
        return
    remedy = "with free edges; set sound.surroundings: baffle"
    if response.radiation not in (None, "none"):
        message = f"must be none, or omitted for air on both faces, {remedy} for it"
        yield Mistake(("response", "radiation"), message)
    if not response.air_mass:
        yield Mistake(("response", "air_mass"), f"must be true {remedy} for resistance alone")
    if response.modal_damping == "diagonal" and study.radiation != "none":
        message = "needs response.radiation: none with free edges; the paper's form has no air"
        yield Mistake(("response", "modal_damping"), message)
    thickness = study.panel.section.thickness
    if thickness < float("inf") and sound.wall < LEAST_GAP * thickness:
        message = f"must be at least a tenth of the panel's thickness, {LEAST_GAP * thickness:.3g}"
        yield Mistake(("sound", "surroundings", "wall_m"), message)


def mistakes_of_coupled(study: Study) -> Iterator[Mistake]:
    """Yield what panel and particles cannot be integrated with."""
    names = [name for name in study.beds(COUPLED) if name in study.scenario_dampers]
    if not names:
        if "coupled" in study.damping.model_fields_set:
            message = "only allowed with a damper with model: coupled in a scenario"
            yield Mistake(("damping", "coupled"), message)
        return
    yield from _mistakes_of_lines(study)
    if study.response.modal_damping != "full":
        for name in names:
            message = "coupled is only allowed with response.modal_damping: full"
            yield Mistake(("dampers", name, "model"), message)
    for name, layout in study.layouts.items():
        models = {
            patch: damper.model
            for patch, filling in layout.layout.items()
            if isinstance(damper := study.dampers.get(filling.damper or names[0]), BedDamper)
        }
        if COUPLED in models.values():
            for patch in (patch for patch, model in models.items() if model == TONES):
                message = "must not have model: tones beside a damper with model: coupled"
                yield Mistake(("scenarios", name, "layout", patch), message)


def _mistakes_of_lines(study: Study) -> Iterator[Mistake]:
    """Yield records that have too few lines in the range of the response, 1/T apart."""
    low, high = study.response.frequency_hz
    shortest = max(FEWEST_LINES / (high - low), FEWEST_PERIODS / low)
    if study.damping.coupled.duration_s < shortest:
        message = f"must be at least {shortest:.3g} for response.frequency_hz = [{low:g}, {high:g}]"
        yield Mistake(("damping", "coupled", "duration_s"), message)


def mistakes_of_labels(study: Study) -> Iterator[Mistake]:
    """Yield entries with a scenario whose label another scenario has, and maps of no scenario."""
    named: dict[str, Scenario] = {}
    for name, compared in study.scenarios.items():
        for scenario in study.family_scenarios(name):
            for labelled in (scenario.bare, scenario):
                if named.setdefault(labelled.label, labelled) == labelled:
                    continue
                keys = () if isinstance(compared, Layout) else (compared.varied,)
                remedy = "give the layout another name"
                if keys and named[labelled.label].patches == labelled.patches:
                    remedy = "values must differ in their first six digits"
                message = f"two scenarios would have the name {labelled.label}; {remedy}"
                yield Mistake(("scenarios", name, *keys), message)
    labels = [scenario.label for scenario in study.all_scenarios()]
    for index, label in enumerate(study.response.maps):
        if label not in labels:
            yield Mistake(("response", "maps", index), f"must be one of {', '.join(labels)}")


def mistakes_of_measurements(study: Study) -> Iterator[Mistake]:
    """Yield measurements of no point or scenario."""
    yield from mistakes_of_names("measurements", study.measurements)
    labels = [scenario.label for scenario in study.all_scenarios()]
    for name, measured in study.measurements.items():
        yield from mistakes_of_point(study, measured.point, ("measurements", name, "point"))
        if measured.excitation is not None and getattr(study, measured.excitation) is None:
            message = f"only allowed with a section {measured.excitation}"
            yield Mistake(("measurements", name, "excitation"), message)
        if measured.scenario is not None and measured.scenario not in labels:
            message = f"must be one of {', '.join(labels)}"
            yield Mistake(("measurements", name, "scenario"), message)


def mistakes_of_claims(study: Study) -> Iterator[Mistake]:
    """Yield claims on scenarios that are not there, or without sound."""
    if study.claims and study.sound is None:
        yield Mistake(("claims",), "only allowed with a section sound")
    for number, claim in enumerate(study.claims):
        yield from (m.prefix("claims", number) for m in claim.mistakes_with(study.families))


def mistakes_of_optimise(section: Optimise, study: Study) -> Iterator[Mistake]:
    """Yield dampers and points that are not there, and dampers that cannot be placed."""
    is_of_modes = isinstance(study.panel, Structure) and study.panel.modes is not None
    if is_of_modes and section.objective == "stress":
        yield Mistake(("objective",), "stress is not known with structure.modes")
    if study.response.modal_damping != "full":
        yield Mistake((), "only allowed with response.modal_damping: full")
    wanted = section.excitation or ("base" if study.sound is None else "sound")
    if wanted != "base" and study.sound is None:
        yield Mistake(("excitation",), f"{wanted} needs a section sound")
    if wanted != "sound" and (study.base is None or study.base.random is None):
        yield Mistake(("excitation",), f"{wanted} needs base.random")
    (low, high), band = study.response.frequency_hz, section.band_hz
    if band is not None and not low <= band[0] < LEAST_BAND * band[0] <= band[1] <= high:
        message = f"must be two values from {low:g} to {high:g}, the frequencies of the response, "
        yield Mistake(("band_hz",), f"{message}the second at least {LEAST_BAND:g} times the first")
    names = list(study.dampers)
    if not names:
        yield Mistake(("dampers",), "there are no dampers to choose from; add a section dampers")
    for index, name in enumerate(section.dampers):
        if name not in names:
            yield Mistake(("dampers", index), not_among("dampers", name, names))
    for index, name in enumerate(section.points):
        yield from mistakes_of_point(study, name, ("points", index))
    for name in section.dampers or names:
        damper = study.dampers.get(name)
        if damper is None:
            continue
        if isinstance(damper, BedDamper) and damper.model == COUPLED:
            message = f"{name} needs its damping over Γ: model: atlas or tones, or a table"
            yield Mistake(("dampers",), message)
        if damper.kind == "law":
            yield Mistake(("dampers",), f"{name} is a law without mass, which no budget limits")
        if damper.needs_fill and not section.fill_fraction:
            yield Mistake(("fill_fraction",), f"missing; required for the damper {name}")


def mistakes_of_severity(study: Study) -> Iterator[Mistake]:
    """Yield too few cycles, a strength of no core."""
    severity = study.severity
    if severity is None:
        return
    lowest = study.response.frequency_hz[0]
    if severity.duration_s * lowest < LEAST_CYCLES:
        message = f"must be at least {LEAST_CYCLES / lowest:.3g}, {LEAST_CYCLES:g} cycles of the "
        yield Mistake(("severity", "duration_s"), f"{message}lowest frequency of the response")
    has_core = study.panel.section.kind == "sandwich"
    if severity.strength is not None and severity.strength.core is not None and not has_core:
        yield Mistake(("severity", "strength", "core"), "only allowed with a sandwich section")
    is_divided = isinstance(study.panel, Structure) and study.panel.has_parts
    if severity.strength is not None and is_divided:
        message = "not allowed with structure.shell.parts, whose stresses are not computed"
        yield Mistake(("severity", "strength"), message)


def mistakes_of_limits(study: Study) -> Iterator[Mistake]:
    """Yield limits of no point, and of no random motion."""
    if study.limits and study.sound is None and (study.base is None or study.base.random is None):
        yield Mistake(("limits",), "only allowed with a section sound or base.random")
    for point in study.limits:
        yield from mistakes_of_point(study, point, ("limits", point))


FILLS = (0.05, 0.95)  # range of the fill fraction r
RESTITUTION, FRICTION = (0.3, 0.95), (0.05, 0.8)  # of e and μ, equal for particles and walls
ATLAS_RANGES = {"restitution": RESTITUTION, "friction": FRICTION, "fill_fraction": FILLS}
WIDTH, DEPTH = (2.0, 10.0), (4.0, 40.0)  # of a cell over the diameter
REMEDY = "; model: coupled or tones simulates it"


def mistakes_of_atlas(study: Study) -> Iterator[Mistake]:
    """Yield what of the dampers that are read from the atlas, or start from it, lies outside."""
    for name, bed in study.beds(*BEDS).items():
        if bed.is_of_atlas:
            yield from (m.prefix("dampers", name) for m in mistakes_of_coupon(bed))
            for way, fill in study.fills(name):
                yield from mistakes_of_fill(way, fill)


def mistakes_of_tolerances(study: Study) -> Iterator[Mistake]:
    """Yield errors of inputs whose derivatives the atlas does not have."""
    mistakes: dict[Mistake, None] = {}
    for scenario in study.all_scenarios():
        for patch, filling in scenario.fillings.items():
            stated, faults = [filling.fill_fraction], [Mistake(("particles",), "missing; required")]
            if isinstance(damper := study.damper_in(scenario, patch), BedDamper):
                stated += [getattr(damper.particles, key) for key in ("restitution", "friction")]
                faults = [m for m in mistakes_of_coupon(damper) if m.keys[-1] != "law"]
            for keys, message, *_ in faults if any(map(error_of, stated)) else ():
                words = message.removesuffix(REMEDY).removesuffix(" for model: atlas")
                message = f"{words} where particles or fill_fraction have an error"
                mistakes[Mistake(("dampers", str(filling.damper), *keys), message)] = None
    yield from mistakes


def mistakes_of_scenarios(study: Study) -> Iterator[Mistake]:
    """Yield patches and dampers that are not there, and fills that a damper does not have."""
    for name, compared in study.scenarios.items():
        for part in compared.parts():
            mistakes = _mistakes_of_part(study, part)
            yield from (mistake.prefix("scenarios", name, *part.way) for mistake in mistakes)


def _mistakes_of_part(study: Study, part: Part) -> Iterator[Mistake]:
    patches, names = list(study.panel.patches), list(study.dampers)
    for keys, patch in part.patches:
        if patch not in patches:
            message = not_among("panel.patches", patch, patches)
            yield Mistake(keys, message if patches else "there are no patches")
    for keys, damper in part.dampers:
        if not names:
            yield Mistake(keys, "there are no dampers; add a section dampers")
        elif damper is None and len(names) > 1:
            yield Mistake(keys, f"missing; must be one of dampers: {', '.join(names)}")
        elif damper is not None and damper not in names:
            yield Mistake(keys, not_among("dampers", damper, names))
        else:
            yield from _mistakes_of_fills(study, part, study.name_of(damper))


def _mistakes_of_fills(study: Study, part: Part, name: str) -> Iterator[Mistake]:
    """Yield fills that a damper needs, has not simulated, or does not depend on."""
    damper = study.dampers[name]
    for keys, fill in part.fills:
        if fill is None:
            if damper.needs_fill:
                yield Mistake(keys, f"missing; required for the {damper.kind} of {name}")
        elif isinstance(damper, BedDamper) and damper.model == TONES:
            low, high = (f(damper.sweep.fill_fraction) for f in (min, max))
            if not low <= fill <= high:
                message = f"must be in the range of dampers.{name}.sweep, {low:g} to {high:g}"
                yield Mistake(keys, message)
        elif not damper.needs_fill and damper.kind != "table":  # its columns decide
            message = f"not allowed: the {damper.kind} of {name} does not depend on the fill"
            yield Mistake(keys[:1], f"{message} fraction")
            return


def mistakes_of_steady_acceleration(study: Study) -> Iterator[Mistake]:
    """Yield a steady acceleration of a scenario that none of its dampers feels or can have."""
    for name, compared in study.scenarios.items():
        if compared.steady_acceleration_g is None:
            continue
        keys: Keys = ("scenarios", name, "steady_acceleration_g")
        beds = {
            scenario.fillings[patch].damper: damper
            for scenario in study.family_scenarios(name)
            for patch in scenario.patches
            if isinstance(damper := study.damper_in(scenario, patch), BedDamper)
        }
        if not beds:
            yield Mistake(keys, "not allowed: none of its dampers is a bed of particles")
        for filler, bed in beds.items():
            if bed.model == TONES:
                message = f"not for model: tones; state dampers.{filler}.steady_acceleration_g"
                yield Mistake(keys, message)
            elif bed.is_of_atlas and not bed.gravity:
                message = f"must not cancel gravity of {filler} for model: atlas{REMEDY}"
                yield Mistake(keys, message)


def mistakes_of_fill(keys: Keys, fill: float) -> Iterator[Mistake]:
    """Yield a fill fraction outside the atlas."""
    if not FILLS[0] <= fill <= FILLS[1]:
        yield Mistake(keys, _outside(FILLS))


def mistakes_of_coupon(coupon: Coupon) -> Iterator[Mistake]:
    """Yield what of a coupon lies outside the atlas."""
    particles, cell = coupon.particles, coupon.cell
    diameter = coupon.diameters[0] * 1e3
    conditions: Mapping[Keys, tuple[bool, str]] = {
        ("cell", "shape"): (cell.shape == "hexagon", "hexagon"),
        ("particles", "distribution"): (isinstance(particles.distribution, Mono), "kind: mono"),
        ("particles", "rolling_friction"): (particles.rolling_friction == 0, "0"),
        ("particles", "restitution", "law"): (particles.impacts.law == "constant", "constant"),
        ("gravity_g",): (coupon.gravity > 0, "above 0"),
    }
    steady = coupon.steady_acceleration_g
    for keys, (is_met, allowed) in conditions.items():
        if not is_met:
            sum_g = ""
            if steady is not None and keys == ("gravity_g",):
                sum_g = f" with steady_acceleration_g = {vector_text(steady)}"
            yield Mistake(keys, f"must be {allowed}{sum_g} for model: atlas{REMEDY}")
    own = {"restitution": particles.impacts.value, "friction": particles.friction}
    for key, value in own.items():
        if getattr(coupon.walls, key) not in (None, value):
            message = f"must equal particles.{key} for model: atlas{REMEDY}"
            yield Mistake(("walls", key), message)
    ranges: Mapping[Keys, tuple[float, tuple[float, float], float]] = {
        ("particles", "restitution"): (own["restitution"], RESTITUTION, 1.0),
        ("particles", "friction"): (particles.friction, FRICTION, 1.0),
        ("cell", "across_flats_mm"): (cell.across_flats_mm, WIDTH, diameter),
        ("cell", "depth_mm"): (cell.depth_mm, DEPTH, diameter),
    }
    for keys, (size, (low, high), unit) in ranges.items():
        if not low * unit <= size <= high * unit:
            yield Mistake(keys, _outside((low * unit, high * unit)) + REMEDY)


def _outside(allowed: tuple[float, float]) -> str:
    return f"must be in the range of the atlas, {allowed[0]:g} to {allowed[1]:g}"
