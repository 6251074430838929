"""Experiments that others made, computed from their stated inputs.

Nothing is fitted: the inputs stand here, and the page (`validation_page`) shows measured, computed
and difference, and what was not known. Numbers without a reference of their own are shown alone.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupon import contact
from pidpanel.coupon.packing import Constants
from pidpanel.verification.coupon import contacts, shaken
from pidpanel.verification.rows import Comparison, Row

# ---- oblique impact of a sphere on a wall

KHARAZ = "Oblique impact of alumina on glass (Kharaz et al. 2001)"
KHARAZ_SOURCE = (
    "Kharaz, Gorham & Salman, Powder Technology 120, 281 (2001), as digitised in MFIX and Lethe"
)
# Angles from the normal [°] and tangential restitution; angles and spin after the impact [rad/s].
RESTITUTION = {
    2.03: 0.7938, 3.93: 0.7450, 9.63: 0.6728, 20.08: 0.5964, 30.22: 0.6883, 39.30: 0.7719,
    49.55: 0.8469, 59.84: 0.9019,
}  # fmt: skip
SPIN = {
    6.00: 135.6, 10.98: 264.5, 21.19: 577.0, 31.09: 612.6, 39.03: 595.5, 50.22: 452.9, 60.25: 381.3,
}  # fmt: skip
SPEED, DIAMETER, DENSITY = 3.9, 5e-3, 4000.0  # [m/s], [m], [kg/m³]
ALUMINA_GLASS = replace(
    Constants.alike(380e9, 0.23, 0.98, 0.092), wall_youngs_modulus=70e9, wall_poissons_ratio=0.25
)
SOFTENED = (1.0, 100.0, 1000.0)  # moduli of the materials over those of the run


def impact_rows(folder: Path) -> list[Row]:
    """Tangential restitution and spin over the angle, at real and at softened moduli."""
    method = "one sphere on a flat wall, step 0.05 Rayleigh"
    rows = []
    for softened in SOFTENED:
        moduli = "moduli of the materials" if softened == 1 else f"softened {softened:g} times"
        for quantity, unit, measured, values in _impacts(folder / f"{softened:g}", softened):
            comparison = Comparison(KHARAZ, unit, math.nan, method, KHARAZ_SOURCE)
            rows += [
                comparison.row(f"{quantity} at {angle:.4g}°, {moduli}", value, reference, angle)
                for (angle, reference), value in zip(measured.items(), values, strict=True)
            ]
    return rows


def _impacts(folder: Path, softened: float) -> list[tuple[str, str, dict[float, float], Array]]:
    """Quantity, unit, measured and computed values."""
    constants = replace(
        ALUMINA_GLASS,
        youngs_modulus=ALUMINA_GLASS.youngs_modulus / softened,
        wall_youngs_modulus=ALUMINA_GLASS.wall_youngs_modulus / softened,
    )
    material = DENSITY, constants.youngs_modulus, constants.poissons_ratio
    time_step = 0.05 * contact.rayleigh_time(DIAMETER / 2, *material)
    angles = np.radians([*RESTITUTION, *SPIN])
    vx, vz = SPEED * np.sin(angles), -SPEED * np.cos(angles)
    gap = 2.5e-4 * DIAMETER
    spheres = [
        contacts.FreeSphere(0.0, DIAMETER / 2 + gap, float(u), float(w), lane=lane)
        for lane, (u, w) in enumerate(zip(vx, vz, strict=True))
    ]
    # two bodies of alumina are stiffer than alumina on glass, by less than three in time
    slowest = float(-vz.max())
    lasting = gap / slowest + 5 * contact.wall_contact_time(DIAMETER / 2, *material, slowest)
    ends = contacts.moved(
        folder,
        spheres,
        constants,
        time_step,
        math.ceil(lasting / time_step),
        ("vx", "vz", "omegay"),
        diameter=DIAMETER,
        density=DENSITY,
        floor=True,
    )
    first = len(RESTITUTION)
    restitution = ends[-1, :first, 0] / ends[0, :first, 0]
    return [
        ("tangential restitution", "1", RESTITUTION, restitution),
        ("spin", "rad/s", SPIN, ends[-1, first:, 2]),
    ]


# ---- beds

OPEN_BED = "Open bed under gravity at large acceleration (Masmoudi et al. 2016)"
OPEN_GAMMAS, OPEN_FREQUENCY, MODULUS = (8.0, 12.0, 20.0, 30.0), 100.0, 3.2e7  # [1], [Hz], [Pa]


def open_bed_rows(folder: Path) -> list[Row]:
    """Exponent of the loss factor over Γ."""
    bed = shaken.poured(folder / "pour")[: shaken.BED_SIZES[-1]]
    loss = []
    for gamma in OPEN_GAMMAS:
        run = shaken.open_bed(OPEN_FREQUENCY, gamma, MODULUS)
        energy, _ = shaken.shaken(folder / f"{gamma:g}", run, bed, 60)
        loss.append(energy[20:].mean() / math.pi)
    exponent = np.polyfit(np.log(OPEN_GAMMAS), np.log(loss), 1)[0]
    comparison = Comparison(
        OPEN_BED, "1", math.nan, f"{len(bed)} spheres in four layers, {OPEN_FREQUENCY:g} Hz",
        "Masmoudi et al. 2016; Ferreyra & Pugnaloni, arXiv 2007.07961 (abstract)",
    )  # fmt: skip
    span = f"Γ from {OPEN_GAMMAS[0]:g} to {OPEN_GAMMAS[-1]:g}"
    return [comparison.row(f"exponent of the loss factor, {span}", exponent, -1.0)]


BOX = "Weightless box: where collect and collide ends (Sack et al. 2013)"
BOX_GAPS = (2.5, 2.8, 3.1, 3.3, 3.5, 3.7, 4.0)  # L/A


def box_rows(folder: Path) -> list[Row]:
    """L/A at which the loss of a bed falls to three quarters of the largest."""
    settled = shaken.poured(folder / "pour")
    energy = [
        shaken.slug(folder / f"{gap:g}", settled, shaken.BED_SIZES[-1], gap, count=16)[1]
        for gap in BOX_GAPS
    ]
    beds = f"{shaken.BED_SIZES[-1]} spheres, e = {shaken.BED_RESTITUTION:g}"
    comparison = Comparison(
        BOX, "1", math.nan, f"{beds}, {len(BOX_GAPS)} gaps",
        "Sack et al., Phys. Rev. Lett. 111, 018001 (2013); A = L/π",
    )  # fmt: skip
    quantity = "L/A at which the loss falls to three quarters of the largest"
    return [comparison.row(quantity, falls_to(0.75, BOX_GAPS, energy), math.pi)]


def falls_to(share: float, points: Sequence[float], values: Sequence[float]) -> float:
    """First point behind the largest value where that share of it is met; NaN for none.

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


PERIODS = "Periods of a bed on a shaken floor (Jiang, Wang & Wu 2006)"
PERIOD_GAMMAS = tuple(np.arange(2.5, 11.6, 1.0).tolist())
SEQUENCE = (2, 4, 3, 6)  # between 4 and 3, and after 6, is chaos
PERIOD_FREQUENCY, PERIOD_CYCLES, SETTLING = 20.0, 74, 14
LONGEST_PERIOD, REPEATS = 8, 0.75


def period_rows(folder: Path) -> list[Row]:
    """The periods of a bed as Γ rises, in their order."""
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
    comparison = Comparison(
        PERIODS, "1", math.nan,
        f"{len(bed)} spheres, {PERIOD_FREQUENCY:g} Hz, loss of {PERIOD_CYCLES - SETTLING} cycles "
        f"at {len(PERIOD_GAMMAS)} values of Γ",
        "Jiang, Wang & Wu, EPL 74, 417 (2006) (abstract)",
    )  # fmt: skip
    return [
        comparison.row(
            f"period {number} in the order of Γ, first at Γ = {gamma:g} [cycles]",
            value, reference, gamma,
        )
        for number, ((gamma, value), reference) in enumerate(
            zip(windows, SEQUENCE, strict=False), start=1
        )
    ]  # fmt: skip


def period(energy: Array) -> int:
    """Cycles after which the losses of cycles repeat; 0 for none up to `LONGEST_PERIOD`.

    The shortest that repeats nearly as well as the best, if that repeats clearly better than
    neighbours do.

    Examples
    --------
    >>> period(np.tile([1.0, 3.0], 10)), period(np.ones(20)), period(np.tile([1.0, 2.0, 3.0], 9))
    (2, 1, 3)
    """
    differences = np.array(
        [
            np.sqrt(np.mean((energy[lag:] - energy[:-lag]) ** 2))
            for lag in range(1, LONGEST_PERIOD + 1)
        ]
    )
    if differences[0] <= 0.1 * energy.mean():
        return 1
    best = differences.min()
    if best > REPEATS * differences[0]:
        return 0
    near = best + 0.15 * (differences[0] - best)
    return int(np.argmax(differences <= near)) + 1


CASES = {
    "impact": impact_rows,
    "open_bed": open_bed_rows,
    "box": box_rows,
    "periods": period_rows,
}

# What was not known of each case.
UNKNOWN = {
    KHARAZ: "Friction 0.092, normal restitution 0.98 and density are quoted from memory of the "
    "paper. Near the normal the contact sticks, and micro-slip is not modelled.",
    OPEN_BED: "The range of Γ, the particles and the depth of the bed are not in the abstract; "
    "nor is the range in which the apparent mass goes with Γ⁻², so that this is not compared.",
    BOX: "Particles, restitution and fill are not in the abstract; A = L/π is quoted from memory.",
    PERIODS: "The abstract has the order of the periods (2, 4, chaos, 3, 6, chaos, 4, 8), not the "
    "values of Γ. A period counts here where losses repeat 25 % better after it than from cycle to "
    "cycle.",
}
