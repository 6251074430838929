"""Real LIGGGHTS as a library: the spheres feel what they should, and an error has a name."""

from dataclasses import replace
from typing import NamedTuple

import numpy as np
import pytest

from pidpanel.coupled.beds import StartedBed, cell_of, spheres_of, started
from pidpanel.coupled.pieces import in_child
from pidpanel.coupon import geometry, preparation
from pidpanel.coupon.impacts import ViscoelasticImpacts
from pidpanel.coupon.liggghts.failures import RunStopped
from pidpanel.coupon.liggghts.library import commands

MODULUS = 50e6

pytestmark = pytest.mark.liggghts


def step_of(bed):
    return 0.2 * bed.packing.smallest(MODULUS).rayleigh_time


class Shaken(NamedTuple):
    """By cell [N s]; ``walls`` is the trapezoid rule of the force, of one step to an interval."""

    gained: np.ndarray
    walls: np.ndarray
    weight: np.ndarray
    kicks: np.ndarray
    impulse: np.ndarray


def shaken(bed, folder, intervals, substeps, acceleration):
    """What every cell has received, in two ways."""

    def work(progress):
        from pidpanel.coupon.liggghts.library import load_library

        found, beds = bed
        step = step_of(found)
        spheres = spheres_of(load_library(), StartedBed(found, MODULUS, beds, 0), step, folder)
        rows = preparation.read_bed(beds)
        mass = geometry.masses(rows[:, 3], found.packing.density)
        cell = np.sort(cell_of(rows[:, :2], found.packing.centres))
        of_cells = np.bincount(cell, mass)

        def momentum():
            return np.bincount(cell, mass * spheres.velocity[:, 2])

        before = momentum()
        walls, kicks, impulse = np.zeros((3, len(of_cells)))
        for n in range(intervals):
            kick = acceleration * substeps * step * np.cos(40 * n * substeps * step)
            kick = kick * np.arange(len(of_cells))
            kicks += of_cells * kick
            # half of a step's force acts before it and half after
            walls += spheres.wall_force() * step / 2
            impulse += spheres.advance(kick, substeps)
            walls += spheres.wall_force() * step / 2
        weight = -9.80665 * of_cells * intervals * substeps * step
        return Shaken(momentum() - before, walls, weight, kicks, impulse)

    return in_child(work, "shaken", silence_s=120, cpu_limit_s=120)


def test_the_spheres_of_every_cell_feel_its_walls_its_motion_and_gravity(bed, tmp_path):
    # to rounding
    found = shaken(bed, tmp_path, 3000, 1, 100.0)
    assert np.ptp(found.kicks) > 0.1 * np.abs(found.kicks).max()
    size = np.abs(found.walls).max() + np.abs(found.kicks).max()
    assert found.gained == pytest.approx(found.walls + found.weight + found.kicks, abs=1e-9 * size)
    assert found.impulse == pytest.approx(found.walls, abs=1e-9 * size)


def test_viscoelastic_spheres_get_the_momentum_of_their_walls_and_another_motion(bed, tmp_path):
    found, beds = bed
    law = ViscoelasticImpacts(1.0, 1.25e-3, 1190.0)
    other = replace(found, constants=replace(found.constants, impacts=law))
    usual, viscoelastic = (shaken(one, tmp_path, 3000, 1, 100.0) for one in (bed, (other, beds)))
    received = viscoelastic.walls + viscoelastic.weight + viscoelastic.kicks
    size = np.abs(received).max()
    assert viscoelastic.gained == pytest.approx(received, abs=1e-9 * size)
    assert np.abs(viscoelastic.walls - usual.walls).max() > 1e-3 * size


def test_the_impulse_of_some_steps_is_that_of_the_walls_alone(bed, tmp_path):
    found = shaken(bed, tmp_path, 750, 4, 100.0)
    size = np.abs(found.impulse).max() + np.abs(found.kicks).max()
    assert found.gained == pytest.approx(
        found.impulse + found.weight + found.kicks, abs=1e-9 * size
    )
    # beds have been thrown at their walls, but that of the first cell, which does not move
    assert np.abs(found.impulse[1:]).min() > 2 * np.abs(found.weight).max()


@pytest.mark.parametrize("substeps", [1, 4])
def test_the_energy_of_panel_and_spheres_balances(bed, tmp_path, plate, integrate, substeps):
    # 0.15 s after a blow; the weight of the bed alone does not move the panel by a tenth of it
    def work(progress):
        from pidpanel.coupon.liggghts.library import load_library

        found, beds = bed
        spheres = spheres_of(
            load_library(), started(found, MODULUS, beds), step_of(found), tmp_path
        )
        rows, intervals = 2000, 16 // substeps
        time = np.arange(rows + 1) / rows
        blow = np.where(time < 0.1, np.sin(np.pi * time / 0.1) ** 2, 0.0)
        return integrate(
            plate.modal,
            plate.at_cells,
            plate.at_points,
            plate.area,
            np.full(8, found.packing.cell_area),
            60.0 * blow[:, None] * np.ones(plate.count),
            step_of(found),
            substeps,
            intervals,
            0,
            particles=[spheres],
            start=np.zeros((2, plate.count)),
        )

    balance = in_child(work, "balance", silence_s=120, cpu_limit_s=120).balance
    assert abs(balance.error) < 0.002
    assert 0.02 < balance.particles / balance.excitation < 0.9


def test_an_error_of_liggghts_has_its_words(bed, tmp_path):
    found, beds = bed
    soft = replace(found, constants=replace(found.constants, poissons_ratio=7.0))

    def work(progress):
        from pidpanel.coupon.liggghts.library import load_library

        spheres_of(load_library(), StartedBed(soft, MODULUS, beds, 0), 1e-6, tmp_path)

    with pytest.raises(RunStopped, match="ERROR"):
        in_child(work, "soft", silence_s=60, cpu_limit_s=60)


def test_a_deck_becomes_commands():
    assert commands("fix a all &\n  b # c\n\nrun 0\n") == ["fix a all b", "run 0"]
