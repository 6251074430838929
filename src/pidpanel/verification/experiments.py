"""Experiments that others made, computed from their stated inputs.

Nothing is fitted: the inputs are listed here, and the page (`validation_page`) shows measured and
computed values, differences and unknowns. Numbers without a reference are shown alone.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np
import yaml

from pidpanel.arrays import Array
from pidpanel.atlas.groups import ElasticSphere
from pidpanel.coupon.contact import Constants
from pidpanel.paths import DATA
from pidpanel.verification.coupon import contacts, shaken
from pidpanel.verification.rows import COMPARISONS, Row, cases_of, comparison

# Measured values, and unknowns of each case.
PUBLISHED = yaml.safe_load((DATA / "reference" / "experiments.yaml").read_text(encoding="utf-8"))
RESTITUTION, SPIN, COLLISION = (PUBLISHED[name] for name in ("restitution", "spin", "collision"))

# ---- oblique impact of a sphere on a wall

SPEED, DIAMETER, DENSITY = 3.9, 5e-3, 4000.0  # [m/s], [m], [kg/m³]
ALUMINA_GLASS = replace(
    Constants.alike(380e9, 0.23, 0.98, 0.092), wall_youngs_modulus=70e9, wall_poissons_ratio=0.25
)
SOFTENED = (1.0, 100.0, 1000.0)  # moduli of the materials over those of the run


def impact_rows(folder: Path) -> Iterator[Row]:
    """Compute tangential restitution and spin over the angle, at real and at softened moduli."""
    for softened in SOFTENED:
        moduli = "moduli of the materials" if softened == 1 else f"softened {softened:g} times"
        for quantity, unit, measured, values in _impacts(folder / f"{softened:g}", softened):
            impact = replace(comparison("impact"), unit=unit)
            for (angle, reference), value in zip(measured.items(), values, strict=True):
                yield impact.row(f"{quantity} at {angle:.4g}°, {moduli}", value, reference, angle)


def _impacts(folder: Path, softened: float) -> list[tuple[str, str, dict[float, float], Array]]:
    """Return quantity, unit, measured and computed values of impacts."""
    constants = replace(
        ALUMINA_GLASS,
        youngs_modulus=ALUMINA_GLASS.youngs_modulus / softened,
        wall_youngs_modulus=ALUMINA_GLASS.wall_youngs_modulus / softened,
    )
    material = DENSITY, constants.youngs_modulus, constants.poissons_ratio
    sphere = ElasticSphere(DIAMETER / 2, *material)
    time_step = 0.05 * sphere.rayleigh_time
    angles = np.radians([*RESTITUTION, *SPIN])
    vx, vz = SPEED * np.sin(angles), -SPEED * np.cos(angles)
    gap = 2.5e-4 * DIAMETER
    spheres = [
        contacts.FreeSphere(0.0, DIAMETER / 2 + gap, float(u), float(w), lane=lane)
        for lane, (u, w) in enumerate(zip(vx, vz, strict=True))
    ]
    # two bodies of alumina are stiffer than alumina on glass, by less than three in time
    slowest = float(-vz.max())
    lasting = gap / slowest + 5 * sphere.wall_contact_time(slowest)
    ends = contacts.moved(
        folder, spheres, constants, time_step, math.ceil(lasting / time_step),
        ("vx", "vz", "omegay"), diameter=DIAMETER, density=DENSITY, floor=True,
    )  # fmt: skip
    first = len(RESTITUTION)
    restitution = ends[-1, :first, 0] / ends[0, :first, 0]
    return [
        ("tangential restitution", "1", RESTITUTION, restitution),
        ("spin", "rad/s", SPIN, ends[-1, first:, 2]),
    ]


# ---- code against code

# LIGGGHTS takes no modulus of 1 MPa: it, and with it every force, is this many times larger here,
# speeds are √ of that. Times scale inversely, distances do not.
SCALE = 100.0


def lammps_rows(folder: Path) -> Iterator[Row]:
    """Compute distance, velocity and force of two spheres that collide."""
    diameter, density, gap, speed, step = 4e-3, 2500.0, 1.6e-4, 1.0, 2e-7
    faster = math.sqrt(SCALE)
    spheres = [
        contacts.FreeSphere(0.0, 0.0, vz=speed * faster),
        contacts.FreeSphere(0.0, diameter + gap, vz=-speed * faster),
    ]
    constants = Constants.alike(1e6 * SCALE, 0.4, 0.8, 0.5)
    count = round(max(COLLISION) / step)
    stride = round(1e-5 / step)
    columns = ("z", "vz", "fz")
    frames = contacts.moved(
        folder, spheres, constants, step / faster, count, columns, diameter=diameter,
        density=density, stride=stride,
    )  # fmt: skip
    collision = comparison("lammps", scale=SCALE, faster=faster)
    for time, (distance, velocity, force) in COLLISION.items():
        (z, v, f), (second, _, _) = frames[round(time / step / stride)]
        for quantity, unit, computed, reference in (
            ("distance of the centres", "m", second - z, distance),
            ("velocity", "m/s", v / faster, velocity),
            ("force", "N", f / SCALE, force),
        ):
            name = f"{quantity} at {time * 1e3:g} ms"
            yield replace(collision, unit=unit).row(name, computed, reference, time)


# ---- beds

OPEN_FREQUENCY, MODULUS = 100.0, 3.2e7  # [Hz], [Pa]
# Γ between which exponents are fitted: of the loss factor, and of the apparent mass, which falls
# through zero at 4
OPEN_GAMMAS, MASS_GAMMAS = (8.0, 12.0, 20.0, 30.0), (1.5, 2.0, 2.5, 3.0)


def open_bed_rows(folder: Path) -> Iterator[Row]:
    """Compute the exponents of loss factor and apparent mass over Γ, and the apparent mass."""
    bed = shaken.poured(folder / "pour")[: shaken.BED_SIZES[-1]]
    loss, mass = {}, {}
    for gamma in (*MASS_GAMMAS, *OPEN_GAMMAS):
        run = shaken.open_bed(OPEN_FREQUENCY, gamma, MODULUS)
        energy, inertia = shaken.shaken(folder / f"{gamma:g}", run, bed, 60)
        loss[gamma], mass[gamma] = energy[20:].mean() / math.pi, inertia[20:].mean()
    open_bed = comparison("open_bed", count=len(bed), frequency=OPEN_FREQUENCY)
    for name, gammas, values, reference in (
        ("loss factor", OPEN_GAMMAS, loss, -1.0),
        ("apparent mass", MASS_GAMMAS, mass, -2.0),
    ):
        quantity = f"exponent of the {name}, Γ from {gammas[0]:g} to {gammas[-1]:g}"
        logs = np.log(gammas), np.log([values[gamma] for gamma in gammas])
        yield open_bed.row(quantity, np.polyfit(*logs, 1)[0], reference)
    for gamma, value in mass.items():
        yield open_bed.row(f"apparent mass over mass, Γ = {gamma:g}", value, math.nan, gamma)


BOX_GAPS = (2.5, 2.8, 3.1, 3.3, 3.5, 3.7, 4.0)  # L/A


def box_rows(folder: Path) -> Iterator[Row]:
    """Compute L/A at which the loss of a bed falls to three quarters of the largest."""
    settled = shaken.poured(folder / "pour")
    energy = [
        shaken.slug(folder / f"{gap:g}", settled, shaken.BED_SIZES[-1], gap, count=16)[1]
        for gap in BOX_GAPS
    ]
    count, restitution = shaken.BED_SIZES[-1], shaken.BED_RESTITUTION
    box = comparison("box", count=count, restitution=restitution, gaps=len(BOX_GAPS))
    quantity = "L/A at which the loss falls to three quarters of the largest"
    yield box.row(quantity, falls_to(0.75, BOX_GAPS, energy), math.pi)


def falls_to(share: float, points: Sequence[float], values: Sequence[float]) -> float:
    """Return the first point behind the largest value where that share of it is met; NaN for none.

    Examples
    --------
    >>> falls_to(0.5, [1.0, 2.0, 3.0], [1.0, 4.0, 0.0])
    2.5
    """
    level, start = share * max(values), int(np.argmax(values))
    for index in range(start, len(values) - 1):
        left, right = values[index] - level, values[index + 1] - level
        if left > 0 >= right:
            step = points[index + 1] - points[index]
            return points[index] + step * left / (left - right)
    return math.nan


PERIOD_GAMMAS = tuple(np.arange(2.5, 11.6, 1.0).tolist())
SEQUENCE = (2, 4, 3, 6)  # between 4 and 3, and after 6, is chaos
PERIOD_FREQUENCY, PERIOD_CYCLES, SETTLING = 20.0, 74, 14
LONGEST_PERIOD, REPEATS = 8, 0.75


def periods_rows(folder: Path) -> Iterator[Row]:
    """Compute the periods of a bed as Γ rises, in their order."""
    bed = shaken.poured(folder / "pour")[: shaken.BED_SIZES[-1]]
    periods = []
    for gamma in PERIOD_GAMMAS:
        run = shaken.open_bed(PERIOD_FREQUENCY, gamma, MODULUS)
        energy, _ = shaken.shaken(folder / f"{gamma:g}", run, bed, PERIOD_CYCLES)
        periods.append(period(energy[SETTLING:]))
    windows = [
        (gamma, value)
        for gamma, (previous, value) in zip(PERIOD_GAMMAS, pairwise([1, *periods]), strict=True)
        if value > 1 and value != previous
    ]
    windows += [(math.nan, 0)] * (len(SEQUENCE) - len(windows))
    periods_of = comparison(
        "periods", count=len(bed), frequency=PERIOD_FREQUENCY, cycles=PERIOD_CYCLES - SETTLING,
        gammas=len(PERIOD_GAMMAS),
    )  # fmt: skip
    for number, reference in enumerate(SEQUENCE, start=1):
        gamma, value = windows[number - 1]
        quantity = f"period {number} of the sequence, from Γ = {gamma:g} [cycles]"
        yield periods_of.row(quantity, value, reference, gamma)


def period(energy: Array) -> int:
    """Return the cycles after which the losses of cycles repeat; 0 for none up to `LONGEST_PERIOD`.

    The shortest that repeats nearly as well as the best, if that repeats clearly better than
    neighbours do.

    Examples
    --------
    >>> period(np.tile([1.0, 3.0], 10)), period(np.ones(20)), period(np.tile([1.0, 2.0, 3.0], 9))
    (2, 1, 3)
    """
    lags = range(1, LONGEST_PERIOD + 1)
    differences = np.array([np.sqrt(np.mean((energy[k:] - energy[:-k]) ** 2)) for k in lags])
    if differences[0] <= 0.1 * energy.mean():
        return 1
    best = differences.min()
    if best > REPEATS * differences[0]:
        return 0
    near = best + 0.15 * (differences[0] - best)
    return int(np.argmax(differences <= near)) + 1


CASES = cases_of(globals())

# Unknowns, by the names of their cases.
UNKNOWN = {COMPARISONS[name]["case"]: PUBLISHED["unknown"][name] for name in CASES}
