"""Experiments that others made, computed from their stated inputs; nothing is fitted."""

import math
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np
import pytest

from pidpanel.atlas.groups import ElasticSphere
from pidpanel.coupon.contact import Constants
from tests.verification import spheres
from tests.verification.spheres import FreeSphere, floor_run, moved, shaken

pytestmark = [pytest.mark.validation, pytest.mark.liggghts]


# ---- oblique impact of a sphere on a wall

# Angle from the normal [°] → tangential restitution; spin after the impact [rad/s].
RESTITUTION = {2.03: 0.7938, 3.93: 0.745, 9.63: 0.6728, 20.08: 0.5964, 30.22: 0.6883,
               39.3: 0.7719, 49.55: 0.8469, 59.84: 0.9019}  # fmt: skip
SPIN = {6.0: 135.6, 10.98: 264.5, 21.19: 577.0, 31.09: 612.6, 39.03: 595.5, 50.22: 452.9,
        60.25: 381.3}  # fmt: skip
SOFTENED = (1.0, 100.0, 1000.0)  # moduli of the materials over those of the run


def glass_impacts(folder, softened):
    """Tangential restitution and spin of impacts of alumina on glass, by angle."""
    constants = replace(
        Constants.alike(380e9 / softened, 0.23, 0.98, 0.092),
        wall_youngs_modulus=70e9 / softened, wall_poissons_ratio=0.25,
    )  # fmt: skip
    diameter, density, speed = 5e-3, 4000.0, 3.9
    sphere = ElasticSphere(
        diameter / 2, density, constants.youngs_modulus, constants.poissons_ratio
    )
    step, gap = 0.05 * sphere.rayleigh_time, 2.5e-4 * diameter
    angles = np.radians([*RESTITUTION, *SPIN])
    vx, vz = (speed * np.sin(angles)).tolist(), (-speed * np.cos(angles)).tolist()
    bodies = [
        FreeSphere(0.0, diameter / 2 + gap, u, w, lane=lane)
        for lane, (u, w) in enumerate(zip(vx, vz, strict=True))
    ]
    # two bodies of alumina are stiffer than alumina on glass, by less than three in time
    slowest = -max(vz)
    steps = math.ceil((gap / slowest + 5 * sphere.wall_contact_time(slowest)) / step)
    first, last = moved(
        folder, bodies, constants, steps, ("vx", "vz", "omegay"), time_step=step,
        diameter=diameter, density=density, floor=True,
    )  # fmt: skip
    count = len(RESTITUTION)
    return last[:count, 0] / first[:count, 0], last[count:, 2]


def test_impacts_that_slide_are_those_of_the_experiment(record, tmp_path):
    row = partial(
        record, case="Oblique impact of alumina on glass (Kharaz et al. 2001)",
        method="one sphere on a flat wall, step 0.05 Rayleigh",
        source="Kharaz, Gorham & Salman, Powder Technology 120, 281 (2001), as digitised in MFIX "
        "and Lethe",
        unknown="Diameter, density, moduli and friction (0.092) are those of the example "
        "3d-oblique-wall-impact of Lethe, where the normal restitution is 1. The value used here, "
        "0.98, could not be checked against the paper; it lowers the friction impulse by 1 %. Near "
        "normal incidence the contact sticks, and micro-slip is not modelled.",
    )  # fmt: skip
    sticking = []
    for softened in SOFTENED:
        moduli = "moduli of the materials" if softened == 1 else f"softened {softened:g} times"
        restitution, spin = glass_impacts(tmp_path / f"{softened:g}", softened)
        for (angle, reference), value in zip(RESTITUTION.items(), restitution, strict=True):
            quantity = f"tangential restitution at {angle:.4g}°, {moduli}"
            # the experiment scatters by 1 %
            assert abs(row(quantity, value, reference)) < 0.01 or angle < 30
        for (angle, reference), value in zip(SPIN.items(), spin, strict=True):
            row(f"spin at {angle:.4g}°, {moduli}", value, reference, unit="rad/s")
        sticking.append(restitution[list(RESTITUTION).index(9.63)])
    # micro-slip near the normal is not modelled, and softer contacts stick less
    assert np.all(np.diff(sticking) < -0.01)


# ---- code against code

# Time [s] → distance of the centres [m], velocity [m/s] and force [N] of the first sphere.
COLLISION = {
    0.00025: (0.003682262, 0.8137313, -0.17744066),
    0.00047: (0.0034644437, 0.11337783, -0.31665837),
    0.00075: (0.0036623172, -0.7071105, -0.1245966),
    0.00095: (0.0039758475, -0.80241211, 0.015295834),
    0.00100: (0.0040558808, -0.79999999, 0.0),
}


def test_a_collision_is_that_of_lammps(record, tmp_path):
    # LIGGGHTS takes no modulus of 1 MPa: it, and with it every force, is this many times larger
    # here, speeds are √ of that. Times scale inversely, distances do not.
    scale, faster = 100.0, 10.0
    diameter, step, stride = 4e-3, 2e-7, 50
    bodies = [
        FreeSphere(0.0, 0.0, vz=faster), FreeSphere(0.0, diameter + 1.6e-4, vz=-faster)
    ]  # fmt: skip
    frames = moved(
        tmp_path, bodies, Constants.alike(1e6 * scale, 0.4, 0.8, 0.5),
        round(max(COLLISION) / step), ("z", "vz", "fz"), time_step=step / faster,
        diameter=diameter, density=2500.0, stride=stride,
    )  # fmt: skip
    row = partial(
        record, case="Head-on collision of two spheres in LAMMPS (examples/granular/in.restitution)",
        method=f"moduli {scale:g} times and speeds {faster:g} times larger, which is the same motion",
        source="lammps/lammps, log of version 4 Feb 2025: Hertz, e = 0.8, 1 MPa, ν = 0.4, ±1 m/s",
        unknown="Nothing: the log has the motion to eight digits. Other reference cases could not "
        "be used. In LAMMPS, those with friction (pouring, chute, drum) start from random positions "
        "that are not stored, or use Hooke's law. The source of DynamO's packer case (a box on a "
        "leaf spring) does not state the number of grains or their diameter, and its help speaks of "
        "radii where the code uses diameters.",
    )  # fmt: skip
    computed = []
    for time, reference in COLLISION.items():
        (z, v, f), (second, _, _) = frames[round(time / step / stride)]
        computed.append((second - z, v / faster, f / scale))
        for quantity, unit, *pair in zip(
            ("distance of the centres", "velocity", "force"), ("m", "m/s", "N"), computed[-1],
            reference, strict=True,
        ):  # fmt: skip
            row(f"{quantity} at {time * 1e3:g} ms", *pair, unit=unit)
    # the same law in another program, with a step 200 times longer; forces to 1.2e-4 of the largest
    reference = np.array(list(COLLISION.values()))
    missed = np.abs(computed - reference).max(axis=0) / np.abs(reference).max(axis=0)
    assert missed.max() < 2e-4


# ---- beds

MODULUS = 3.2e7  # [Pa]


@pytest.fixture(scope="module")
def bed(tmp_path_factory):
    return spheres.poured(tmp_path_factory.mktemp("pour"))[: spheres.BED_COUNT]


@pytest.mark.long
def test_an_open_bed_loses_less_and_weighs_less_with_its_acceleration(record, tmp_path, bed):
    # Γ between which exponents are fitted: of the loss factor, and of the apparent mass, which
    # falls through zero at 4
    loss_gammas, mass_gammas = (8.0, 12.0, 20.0, 30.0), (1.5, 2.0, 2.5, 3.0)
    frequency, loss, mass = 100.0, {}, {}
    for gamma in (*mass_gammas, *loss_gammas):
        run = floor_run(frequency, gamma, MODULUS)
        energy, inertia = shaken(tmp_path / f"{gamma:g}", run, bed, 60)
        loss[gamma], mass[gamma] = energy[20:].mean() / math.pi, inertia[20:].mean()
    row = partial(
        record, case="Open bed under gravity at large acceleration (Masmoudi et al. 2016)",
        method=f"{len(bed)} spheres in four layers, {frequency:g} Hz",
        source="Masmoudi et al. 2016; Ferreyra & Pugnaloni, arXiv 2007.07961 (abstract)",
        unknown="The abstract does not state the ranges of Γ, the particles or the depth of the bed. "
        "It says that the apparent mass is proportional to Γ⁻² at moderate Γ and negative at very "
        "high Γ. Here the apparent mass is zero near Γ = 4, so its exponent depends on the range. "
        "The values are listed below.",
    )  # fmt: skip
    for name, gammas, values, reference in (
        ("loss factor", loss_gammas, loss, -1.0), ("apparent mass", mass_gammas, mass, -2.0)
    ):  # fmt: skip
        exponent = np.polyfit(np.log(gammas), np.log([values[gamma] for gamma in gammas]), 1)[0]
        quantity = f"exponent of the {name}, Γ from {gammas[0]:g} to {gammas[-1]:g}"
        row(quantity, exponent, reference)
    for gamma, value in mass.items():
        row(f"apparent mass over mass, Γ = {gamma:g}", value, math.nan)


@pytest.mark.long
def test_collect_and_collide_ends_where_a_thrown_body_crosses_in_half_a_period(
    record, tmp_path, bed
):
    gaps = (2.5, 2.8, 3.1, 3.3, 3.5, 3.7, 4.0)  # L/A
    energy = [
        shaken(tmp_path / f"{gap:g}", spheres.slug_run(bed, gap), bed, 16)[0][2:].mean()
        for gap in gaps
    ]
    record(
        "L/A at which the loss falls to three quarters of the largest",
        falls_to(0.75, gaps, energy), math.pi,
        case="Weightless box: where collect and collide ends (Sack et al. 2013)",
        method=f"{len(bed)} spheres, e = {spheres.BED_RESTITUTION:g}, {len(gaps)} gaps",
        source="Sack et al., Phys. Rev. Lett. 111, 018001 (2013); A = L/π",
        unknown="The abstract does not state the particles, the restitution or the fill fraction. "
        "The measured value, A = L/π, could not be checked against the paper. It is also the "
        "amplitude at which a body thrown at ωA crosses L in half a period.",
    )  # fmt: skip


def falls_to(share, points, values):
    """The first point behind the largest value where that share of it is met; NaN for none."""
    level, start = share * max(values), int(np.argmax(values))
    for (left, high), (right, low) in pairwise(zip(points[start:], values[start:], strict=True)):
        if high > level >= low:
            return left + (right - left) * (high - level) / (high - low)
    return math.nan


def test_a_loss_falls_to_a_share_between_two_points_or_nowhere():
    assert falls_to(0.5, [1.0, 2.0, 3.0], [1.0, 4.0, 0.0]) == 2.5
    assert np.isnan(falls_to(0.5, [1.0, 2.0], [1.0, 2.0]))


@pytest.mark.long
def test_the_periods_of_a_bed_come_in_their_order(record, tmp_path, bed):
    gammas, sequence = np.arange(2.5, 11.6, 1.0).tolist(), (2, 4, 3, 6)
    frequency, cycles, settling = 20.0, 74, 14
    periods = []
    for gamma in gammas:
        run = floor_run(frequency, gamma, MODULUS)
        periods.append(period(shaken(tmp_path / f"{gamma:g}", run, bed, cycles)[0][settling:]))
    windows = [
        (gamma, value)
        for gamma, (previous, value) in zip(gammas, pairwise([1, *periods]), strict=True)
        if value > 1 and value != previous
    ]
    windows += [(math.nan, 0)] * (len(sequence) - len(windows))
    for number, reference in enumerate(sequence, start=1):
        gamma, value = windows[number - 1]
        record(
            f"period {number} of the sequence, from Γ = {gamma:g} [cycles]", value, reference,
            case="Periods of a bed on a shaken floor (Jiang, Wang & Wu 2006)",
            method=f"{len(bed)} spheres, {frequency:g} Hz, loss of {cycles - settling} cycles at "
            f"{len(gammas)} values of Γ",
            source="Jiang, Wang & Wu, EPL 74, 417 (2006) (abstract)",
            unknown="The abstract states the order of the periods (2, 4, chaos, 3, 6, chaos, 4, 8), "
            "but not the values of Γ. The last two, 4 and 8, are not compared. A period is counted "
            "where the losses repeat at least 25 % better after it than from cycle to cycle.",
        )  # fmt: skip


def period(energy):
    """Cycles after which the losses of cycles repeat; 0 for none up to eight.

    The shortest that repeats nearly as well as the best, if that repeats clearly better than
    neighbours do.
    """
    differences = np.array(
        [np.sqrt(np.mean((energy[lag:] - energy[:-lag]) ** 2)) for lag in range(1, 9)]
    )
    if differences[0] <= 0.1 * energy.mean():
        return 1
    best = differences.min()
    if best > 0.75 * differences[0]:
        return 0
    near = best + 0.15 * (differences[0] - best)
    return int(np.argmax(differences <= near)) + 1


@pytest.mark.parametrize("cycles", [[1.0], [1.0, 3.0], [1.0, 2.0, 4.0], [1.0, 5.0, 1.2, 3.0]])
def test_the_period_of_losses_that_repeat_is_found(cycles):
    rng = np.random.default_rng(1)
    energy = np.tile(cycles, 20) * rng.normal(1, 0.03, 20 * len(cycles))
    assert period(energy) == len(cycles)


def test_losses_that_do_not_repeat_have_no_period():
    assert period(np.random.default_rng(1).uniform(0.5, 1.5, 60)) == 0
