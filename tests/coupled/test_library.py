"""Real LIGGGHTS as a library: the spheres feel what they should, and an error has a name."""

from dataclasses import replace

import numpy as np
import pytest

from pidpanel.coupled.beds import spheres_of
from pidpanel.coupled.process import in_child
from pidpanel.coupon import geometry, preparation
from pidpanel.coupon.contact import rayleigh_time
from pidpanel.coupon.liggghts.failures import RunStopped
from pidpanel.coupon.liggghts.library import commands

MODULUS = 50e6

pytestmark = pytest.mark.liggghts


def step_of(bed):
    packing = bed.packing
    return 0.2 * rayleigh_time(
        packing.sizes.smallest / 2, packing.density, MODULUS, packing.poissons_ratio
    )


def shaken(bed, folder, stations, steps, acceleration):
    """Momentum gained, impulse of walls and weight, and of the kicks, by station [N s]."""

    def work(progress):
        from pidpanel.coupon.liggghts.library import load_library

        found, beds = bed
        step = step_of(found)
        spheres = spheres_of(load_library(), found, MODULUS, step, beds, folder, stations)
        rows = preparation.read_bed(beds)
        mass = geometry.masses(rows[:, 3], found.packing.density)
        station = np.repeat(np.arange(stations), len(mass) // stations)

        def momentum():
            return np.bincount(station, mass * spheres.velocity[:, 2])

        of_stations = np.bincount(station, mass)
        before, walls, kicks = momentum(), np.zeros(stations), np.zeros(stations)
        for n in range(steps):
            # half of a step's force acts before it and half after
            walls += spheres.wall_force() * step / 2
            kick = acceleration * step * np.cos(40 * n * step) * np.arange(stations)
            kicks += of_stations * kick
            spheres.step(kick)
            walls += spheres.wall_force() * step / 2
        weight = -9.80665 * of_stations * steps * step
        return momentum() - before, walls + weight, kicks, of_stations

    return in_child(work, "shaken", silence_s=120, limit_s=120)


@pytest.mark.parametrize("stations", [2, 8])
def test_the_spheres_of_every_station_feel_its_walls_its_motion_and_gravity(
    bed, tmp_path, stations
):
    # to rounding; red: `- self._weight` left out; `kick[self._station]` → `kick.mean()`;
    # `atom_modify sort 0 0` left out of the deck
    gained, given, kicks, mass = shaken(bed, tmp_path, stations, 3000, 100.0)
    assert np.ptp(kicks / mass) > 0.1
    size = np.abs(given).max() + np.abs(kicks).max()
    assert gained == pytest.approx(given + kicks, abs=1e-9 * size)


def test_the_energy_of_panel_and_spheres_balances(bed, tmp_path, plate, integrate):
    # 0.15 s after a blow; the weight of the bed alone does not move the panel by a tenth of it
    # red: the sign of `kick`, with which the spheres are moved the other way
    def work(progress):
        from pidpanel.coupon.liggghts.library import load_library

        found, beds = bed
        spheres = spheres_of(load_library(), found, MODULUS, step_of(found), beds, tmp_path, 8)
        rows, steps = 2000, 16
        time = np.arange(rows + 1) / rows
        blow = np.where(time < 0.1, np.sin(np.pi * time / 0.1) ** 2, 0.0)
        return integrate(
            plate.shapes,
            plate.area,
            np.full(8, found.packing.cell_area),
            60.0 * blow[:, None] * np.ones(plate.count),
            step_of(found),
            steps,
            0,
            particles=[spheres],
            start=np.zeros((2, plate.count)),
        )

    balance = in_child(work, "balance", silence_s=120, limit_s=120).balance
    assert abs(balance.error) < 0.002
    assert 0.02 < balance.particles / balance.sound < 0.9


def test_an_error_of_liggghts_has_its_words(bed, tmp_path):
    # red: os.dup2 left out of `process._work`; a library that is loaded in the caller aborts it
    found, beds = bed
    soft = replace(found, constants=replace(found.constants, poissons_ratio=7.0))

    def work(progress):
        from pidpanel.coupon.liggghts.library import load_library

        spheres_of(load_library(), soft, MODULUS, 1e-6, beds, tmp_path, 8)

    with pytest.raises(RunStopped, match="ERROR"):
        in_child(work, "soft", silence_s=60, limit_s=60)


def test_a_deck_becomes_commands():
    # red: replace of " &\n" left out
    assert commands("fix a all &\n  b # c\n\nrun 0\n") == ["fix a all b", "run 0"]
