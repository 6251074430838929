"""The coupon of a study as cases: the only module of the coupon that reads a study."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

from pidpanel.atlas.groups import Direction
from pidpanel.constants import LIGGGHTS_VERSION, STANDARD_GRAVITY
from pidpanel.coupon import contact, summary
from pidpanel.coupon.bed import LOOSENING, Bed, Run, run_at
from pidpanel.coupon.cases import Case, RunTarget
from pidpanel.coupon.contact import Constants
from pidpanel.coupon.drive import Tone
from pidpanel.coupon.impacts import ViscoelasticImpacts
from pidpanel.coupon.liggghts import deck
from pidpanel.coupon.liggghts.failures import DeckRefused
from pidpanel.coupon.packing import Packing
from pidpanel.paths import SECTION
from pidpanel.text_files import TextFileError, read_text

if TYPE_CHECKING:  # pydantic is slow to import, and a run needs none of it
    import pandas as pd

    from pidpanel.study import CouponStudy
    from pidpanel.study.coupon import Coupon
    from pidpanel.study.mistakes import Mistake

LARGEST_DECK = 1_000_000  # most bytes of a deck


def cases_of(coupon: Coupon) -> tuple[Case, ...]:
    """Return every case of a sweep, in the order fill, frequency, amplitude, diameter.

    The combinations of ``vary`` come outermost; those of a table of cases are in its order.
    """
    return tuple(
        case
        for varied, variant in coupon.variants()
        for case in _swept(variant, {key: plain(value) for key, value in varied.items()})
    )


def bed_of(coupon: Coupon, fill_fraction: float, *, cells: int, seed: int) -> Bed:
    """Return a bed with a fill r and a number of cells, of the first of a coupon's diameters."""
    packing = replace(_packing(coupon, coupon.diameters[0], seed), count=cells)
    return _bed(coupon, packing, fill_fraction)


def cases_by_coupon(study: CouponStudy) -> dict[str, dict[str, Case]]:
    """Return every case of every coupon of a study: name of the damper → label of the case → case.

    A case of two coupons is one, run to the accuracy that satisfies both.
    """
    strictest: dict[str, Case] = {}
    by_coupon = {name: cases_of(coupon) for name, coupon in study.coupons.items()}
    for cases in by_coupon.values():
        for case in cases:
            strictest[case.label] = case.as_strict_as(strictest.get(case.label, case))
    return {
        name: {case.label: case.as_strict_as(strictest[case.label]) for case in cases}
        for name, cases in by_coupon.items()
    }


def distinct_cases(study: CouponStudy) -> dict[str, Case]:
    """Return every case of a study once, by its label."""
    by_coupon = cases_by_coupon(study).values()
    return {label: case for cases in by_coupon for label, case in cases.items()}


def write_table(study: CouponStudy, damper: str, folder: Path, file: Path) -> None:
    """Write the ``cases.csv`` of one coupon of a study; see `summary.write_table`."""
    cases = tuple(cases_by_coupon(study)[damper].values())
    coverage = study.coupons[damper].accuracy.coverage
    summary.write_table(cases, folder, file, coverage=coverage)


def mistakes_of_decks(coupon: Coupon) -> Iterator[Mistake]:
    """Yield what is wrong with a coupon's own decks: unknown variables, values without a use."""
    from pidpanel.study.mistakes import Mistake

    varied = [str(path) for path in getattr(coupon, "vary", {}).get("deck", ())]
    mistakes: dict[Mistake, None] = {}
    for case in cases_of(coupon):
        if (path := case.point.deck) is not None:
            # a varied deck is one of a list
            keys = ("vary", "deck", varied.index(path)) if varied else ("deck",)
            mistakes |= {Mistake(keys, fault): None for fault in _faults_of_deck(case.point, path)}
    yield from mistakes
    if mistakes or not coupon.deck_values:
        return
    ours = replace(cases_of(coupon)[0].point, deck_constants=()).deck_values(restart="none")
    used = set().union(*map(deck.variables_in, coupon.decks))
    for name in coupon.deck_values:
        if name in ours:
            yield Mistake(("deck_values", name), "is a variable of all decks; choose another name")
        elif name not in used:
            files = ", ".join(dict.fromkeys(path.name for path in coupon.decks))
            yield Mistake(("deck_values", name), f"not used by {files or 'any deck; state deck'}")


def _faults_of_deck(run: Run, path: str) -> Iterator[str]:
    """Yield what is wrong with the deck of a run."""
    import jinja2

    names = run.deck_values(restart="none")
    try:
        text = read_text(deck.check_trust(Path(path)), LARGEST_DECK)
        unknown = deck.undeclared(text, names)
    except DeckRefused as error:
        yield str(error).removeprefix(f"{path}: ")
        return
    except TextFileError as error:
        place = path if error.line is None else f"{path}:{error.line}"
        yield f"{place}: {error.message}"
        return
    except jinja2.TemplateSyntaxError as error:
        yield f"{path}:{error.lineno}: {error.message}"
        return
    unused = sorted({"cycles_file", "steps_per_cycle"} - set(deck.undeclared(text, ())))
    if not unknown and not unused:
        try:
            run.deck_text()
        except Exception as error:  # whatever a template of somebody else computes
            yield f"{path}: {type(error).__name__}: {error}"
    for name in unknown:
        allowed = ", ".join(sorted(names))
        yield f"unknown variable {name}; allowed are {allowed}, and those of deck_values"
    for name in unused:
        message = f"must use the variable {name}; a deck writes one row per cycle, as "
        yield f"{message}templates/shake.in.j2 does"


def write_atlas(study: CouponStudy, table: Path, file: Path) -> None:
    """Write the cases of a study, from its ``coupon/cases.csv``, in the format of the atlas.

    The title of the study is the source of its rows. A `ValueError` names a case with cells, walls,
    sizes or gravity that the groups of the atlas do not describe.
    """
    import pandas as pd

    cases = cases_by_coupon(study)[SECTION]
    rows = atlas_table(cases, pd.read_csv(table), study.title or study.name)
    rows.to_csv(file, index=False, float_format="%.6g")


def plain(value: Any) -> Any:
    """Return a value for a table."""
    if isinstance(value, Mapping):
        return ", ".join(f"{key} {entry}" for key, entry in value.items())
    if isinstance(value, list | tuple):
        return " ".join(f"{item:g}" for item in value)
    return value.name if isinstance(value, Path) else value


def _swept(coupon: Coupon, varied: Mapping[str, Any]) -> Iterator[Case]:
    sweep, accuracy, diameters = coupon.sweep, coupon.accuracy, coupon.diameters
    # those of a case and, where its bed may have several states, of its reserve
    seeds = range(1, max(accuracy.seeds, accuracy.state_seeds) + 1)
    beds = {
        (fill, diameter, seed): _bed(coupon, packing, fill)
        for diameter in diameters
        for seed in seeds
        for packing in (_packing(coupon, diameter, seed),)
        for fill in sweep.fill_fraction
    }
    for fill, drive, diameter in itertools.product(
        sweep.fill_fraction, list(_drives(coupon)), diameters
    ):
        yield _case(coupon, [beds[fill, diameter, seed] for seed in seeds], drive, varied)


def _case(coupon: Coupon, beds: Sequence[Bed], drive: Tone, varied: Mapping[str, Any]) -> Case:
    """Return the case of a drive, a bed per seed; seeds over ``accuracy.seeds`` are its reserve."""
    accuracy = coupon.accuracy
    stroke = _stroke_of_crossing(beds[0], drive)
    state_cycles = accuracy.state_cycles if coupon.stiffness.crossing.holds_at(stroke) else 0
    # of beds that may have several states every other seed is shaken hard
    is_several = state_cycles > 0 and coupon.deck is None
    runs = tuple(
        run_at(
            bed,
            drive,
            _constants(coupon, bed.packing, drive, stroke, bed.deepening(drive)),
            time_step_rayleigh=coupon.time_step_rayleigh,
            samples_per_cycle=coupon.samples_per_cycle,
            own_deck=None if coupon.deck is None else str(coupon.deck),
            start="hard" if is_several and bed.packing.seed % 2 == 0 else "rest",
            deck_constants=coupon.deck_values if coupon.deck else {},
        )
        for bed in beds[: None if state_cycles else accuracy.seeds]
    )
    fewest = max(accuracy.min_cycles, math.ceil(accuracy.min_time_s * drive.frequency))
    error = accuracy.relative_error * math.sqrt(accuracy.seeds)
    target = RunTarget(error, fewest, max(accuracy.max_cycles, fewest))
    modulus, wanted_error = coupon.particles.youngs_modulus, accuracy.relative_error
    first, reserve = runs[: accuracy.seeds], runs[accuracy.seeds :]
    return Case(first, modulus, wanted_error, target, varied, reserve, state_cycles)


def _stroke_of_crossing(bed: Bed, drive: Tone) -> float:
    """Return W/L; 0 if the bed is not thrown up to the lid, and so rides at any stroke.

    With gravity g along the motion a bed thrown at ωW rises by (ωW)²/2g, which is less than L where
    a W/L < 2g (`jump.reach` of the surface).
    """
    stroke = bed.stroke_per_gap(drive)
    along = bed.gravity * abs(bed.gravity_direction[2])
    return stroke if drive.acceleration * stroke >= 2 * along else 0.0


def _drives(coupon: Coupon) -> Iterator[Tone]:
    """Yield every drive of the sweep that is not too fast, frequency by frequency."""
    sweep = coupon.sweep
    fastest = sweep.max_velocity_m_s or math.inf
    for frequency in sweep.frequencies:
        omega = 2 * math.pi * frequency
        amplitudes = (omega**2 * amplitude for amplitude in sweep.displacements)
        for acceleration in (*amplitudes, *sweep.accelerations):
            drive = Tone(frequency, acceleration)
            if drive.speed <= fastest:
                yield drive


def _of_walls(coupon: Coupon, name: str) -> float:
    """Return a property of the walls, by default that of the particles."""
    stated = getattr(coupon.walls, name)
    return coupon.particles.constant(name) if stated is None else float(stated)


def _packing(coupon: Coupon, diameter: float, seed: int) -> Packing:
    spheres = coupon.particles
    return Packing(
        shape=coupon.cell.shape,
        across_flats=coupon.cell.across_flats,
        depth=coupon.cell.depth,
        count=coupon.cell.count,
        diameter=diameter,
        sizes=spheres.distribution.sizes(diameter),
        density=spheres.effective_density(diameter),
        poissons_ratio=spheres.poissons_ratio,
        friction=spheres.friction,
        wall_friction=_of_walls(coupon, "friction"),
        seed=seed,
    )


def _bed(coupon: Coupon, packing: Packing, fill_fraction: float) -> Bed:
    constants = _constants(coupon, packing, LOOSENING.drive)
    return Bed(packing, fill_fraction, coupon.gravity, coupon.gravity_axis, constants)


def _constants(
    coupon: Coupon,
    packing: Packing,
    drive: Tone,
    stroke_per_gap: float = 0.0,
    deepening: float = 1.0,
) -> Constants:
    """Return the constants with both moduli softened equally, within the limits of the drive.

    Left out, W/L is that of a bed that rides: so is a bed shaken loose, which is no result.
    """
    spheres, stiffness = coupon.particles, coupon.stiffness
    normal = 1.0 if drive is LOOSENING.drive else max(1.0, abs(coupon.apparent_gravity_g[2]))
    thrown = drive.acceleration >= stiffness.from_acceleration_g * STANDARD_GRAVITY * normal
    longest, deepest = stiffness.limits(stroke_per_gap)
    modulus = contact.softest_modulus(
        stiffness.choices if thrown else (),
        replace(packing.smallest(spheres.youngs_modulus), radius=packing.sizes.largest / 2),
        speed=drive.speed,
        frequency=drive.frequency,
        contact_time_per_period=longest / deepening,
        overlap_per_radius=deepest,
    )
    stiffer = _of_walls(coupon, "youngs_modulus") / spheres.youngs_modulus
    names = ("poissons_ratio", "restitution", "friction", "rolling_friction")
    return Constants(
        youngs_modulus=modulus,
        wall_youngs_modulus=modulus * stiffer,
        **{name: spheres.constant(name) for name in names},
        **{f"wall_{name}": _of_walls(coupon, name) for name in names},
        impacts=_impacts(coupon, packing),
    )


def _impacts(coupon: Coupon, packing: Packing) -> ViscoelasticImpacts | None:
    """Return the impacts of spheres of the one size of a packing; None if e is constant."""
    stated = coupon.particles.impacts
    if stated.law == "constant" or stated.at_m_s is None:
        return None
    return ViscoelasticImpacts(stated.at_m_s, packing.diameter / 2, packing.density)


# Statuses of the cases used. A run that is not steady has an error as large as its drift. The
# energy balance misses losses of strongly damped contacts with friction (docs/atlas.md); the
# momentum, from which C_e and m_a come, does not.
COUNTED = ("ok", "NotSteady", "EnergyNotClosed")


def atlas_table(cases: Mapping[str, Case], rows: pd.DataFrame, source: str) -> pd.DataFrame:
    """Return the rows of the atlas, in the order of the cases, by label.

    Rows are those of ``coupon/cases.csv`` without failed cases; the source names who computed them
    with which study. Raises `ValueError` for a case that the groups do not describe.
    """
    import pandas as pd

    from pidpanel.atlas.table import fields

    counted = rows[rows["status"].isin(COUNTED)]
    table = [
        row | _groups(cases[str(row["case"])], row) | {"source": source}
        for row in counted.to_dict("records")
    ]
    return pd.DataFrame(table, columns=[field["name"] for field in fields()])


def _groups(case: Case, row: Mapping[Any, Any]) -> dict[str, Any]:
    """Return the columns of the atlas that are not those of the row too."""
    run, drive = case.point, case.point.drive
    packing, constants = run.packing, run.constants
    _check_groups(case)
    mass = row["particle_mass_per_area_kg_m2"]
    scale = mass * drive.angular_frequency  # of C_e [N s/m³]
    states = [float(value) for value in _listed(row["state_damping_n_s_m3"])]
    return {
        "fill_fraction": run.fill_fraction,
        "gamma": drive.gamma,
        "stroke_per_gap": run.bed.stroke_per_gap(drive),
        "restitution": constants.restitution,
        "friction": constants.friction,
        "width_per_diameter": packing.across_flats / packing.diameter,
        "depth_per_diameter": packing.depth / packing.diameter,
        "direction": _direction(run.bed),
        "loss_factor_statistical_error": row["statistical_error_n_s_m3"] / scale,
        "mass_ratio": row["apparent_mass_kg_m2"] / mass,
        "mass_ratio_error": row["apparent_mass_error_kg_m2"] / mass,
        "state_loss_factors": " ".join(f"{value / scale:.4g}" for value in states),
        "state_shares": " ".join(_listed(row["state_share"])),
        "hardness": packing.density * drive.speed**2 / constants.youngs_modulus,
        "contact_time_per_period": run.contact_time_at(constants.youngs_modulus) * drive.frequency,
        "overlap_per_radius": run.overlap_at(constants.youngs_modulus),
        "cycles": row["cycles_used"],
        "target_met": str(row["target_met"]).lower(),
        "diameter_mm": packing.diameter * 1e3,
        "density_kg_m3": packing.density,
        "youngs_modulus_mpa": constants.youngs_modulus / 1e6,
        "poissons_ratio": constants.poissons_ratio,
        "frequency_hz": drive.frequency,
        "across_flats_mm": packing.across_flats * 1e3,
        "depth_mm": packing.depth * 1e3,
        "liggghts_version": LIGGGHTS_VERSION,
        "pidpanel_version": version("pidpanel"),
    }


def _check_groups(case: Case) -> None:
    """Refuse a case that differs in more than its groups."""
    packing, constants = case.point.packing, case.point.constants
    values = vars(constants)
    walls = {name.removeprefix("wall_"): values[name] for name in values if "wall_" in name}
    faults = {
        "cells must be hexagons": packing.shape != "hexagon",
        "particles must have one size": packing.sizes.kind != "mono",
        "there must be no rolling friction": constants.has_rolling_friction,
        "restitution must not depend on the speed": constants.impacts is not None,
        "walls must have the constants of the particles": bool(walls.items() - values.items()),
    }
    for message, is_wrong in faults.items():
        if is_wrong:
            raise ValueError(f"{case.label}: {message}")


def _direction(bed: Bed) -> Direction:
    """Return the direction of gravity by its name in the groups."""
    size, along = bed.gravity / STANDARD_GRAVITY, bed.gravity_direction[2]
    if size == 0:
        return "none"
    if math.isclose(size, 1) and along == -1:
        return "flat"
    if math.isclose(size, 1) and along == 0:
        return "upright"
    raise ValueError(f"gravity of {size:g} g along {bed.gravity_direction} is not in the atlas")


def _listed(values: object) -> list[str]:
    """Return the values that a cell lists; none of an empty one."""
    return [] if values != values or values is None else str(values).split()
