"""Results of algorithms that enter labels by a version number: other bits need another number.

If a test here fails, the algorithm makes other results than the version with its number. Give it
the next number and put the new results here: runs of the old version are then kept and not used.
"""

import hashlib

import numpy as np
import pytest

from pidpanel.coupon import attempts, bed, packing, rows, runs, states, window
from pidpanel.coupon.liggghts import start_files
from pidpanel.coupon.preparation import BED_FILE, PACKING_FILE, scattered, write_start
from tests.coupons import small_cases

GOLDEN = {
    "placement_hexagon": {"version": 1, "digest": "406a8f7116d53c79"},
    "placement_square": {"version": 1, "digest": "7fa8d0fe2f7dedb7"},
    "pour": {"version": 1, "digest": "0fb713e474bce0bc"},
    "loosen": {"version": 1, "digest": "0589703374409082"},
    "judging": {
        "version": 1,
        "cycles": [40, 40],
        "ended_by": "max_cycles",
        "values": [309.06997776532944, 21.95794598971305, -0.0003343138059412845,
                   0.02586466005229933],
        "states": 2,
        "apart": [False, True, True],
    },
    "balance": {
        "version": 2,
        "values": [1.96620151296275e-06, 1.3734107286373807e-06, -5.875315281913472e-09,
                   -0.002988155203410618],
        "frames": 401,
    },
}  # fmt: skip


def case(shape="hexagon"):
    cell = {"shape": shape, "depth_mm": 8, "count": 2}
    sweep = {"fill_fraction": [0.6], "frequency_hz": [100]}
    values = {"relative_error": 0.05, "seeds": 1, "min_cycles": 12, "max_cycles": 40}
    accuracy = values | {"min_time_s": 0, "state_cycles": 0}
    return small_cases(cell=cell, particles={"friction": 0.3}, sweep=sweep, accuracy=accuracy)[0]


def digest(*texts):
    return hashlib.sha256("".join(texts).encode()).hexdigest()[:16]


@pytest.mark.parametrize("shape", ["hexagon", "square"])
def test_spheres_and_walls_are_placed_as_by_this_version(tmp_path, shape):
    poured = case(shape).point.packing
    start = scattered(poured)
    box = np.array([[0.0, 1.0]] * 3)
    data = start_files.data_file(start.positions, start.diameters, poured.density, box)
    spheres = np.column_stack([start.positions, start.diameters])
    write_start(tmp_path / "run", poured, spheres)
    written = [(tmp_path / "run" / name).read_text() for name in ("start.data", "walls.stl")]
    found = {"version": packing.PLACEMENT_VERSION, "digest": digest(data, *written)}
    assert found == GOLDEN[f"placement_{shape}"]


@pytest.fixture(scope="module")
def prepared(tmp_path_factory):
    folder = tmp_path_factory.mktemp("prepared")
    prepared_bed = case().point.bed
    packing_file, bed_file = folder / "packing" / "packing.json", folder / "bed" / "bed.json"
    attempts.pour_packing(prepared_bed.packing, packing_file)
    attempts.loosen_bed(prepared_bed, packing_file, bed_file)
    return packing_file.parent, bed_file.parent


@pytest.mark.liggghts
def test_a_packing_is_poured_and_a_bed_shaken_loose_as_by_this_version(prepared):
    for name, version, folder, file in (
        ("pour", packing.POUR_VERSION, prepared[0], PACKING_FILE),
        ("loosen", bed.LOOSEN_VERSION, prepared[1], BED_FILE),
    ):
        found = {"version": version, "digest": digest((folder / file).read_text())}
        assert found == GOLDEN[name]


@pytest.mark.liggghts
def test_a_run_is_judged_and_its_energy_measured_as_by_this_version(prepared, tmp_path):
    one = case()
    run = one.point
    found = runs.shake(run, one.target, prepared[1], tmp_path / "run")
    damping, mass = rows.estimates(
        run, rows.read_shaken(run, tmp_path / "run", found), found.mass_kg
    )[:2]
    judged = {
        "version": attempts.JUDGING_VERSION,
        "cycles": [found.cycles, attempts.first_target(one).max_cycles],
        "ended_by": found.ended_by,
        # relative to 1e-9: sums differ in their last digits between processors
        "values": pytest.approx([damping.mean, damping.error, mass.mean, mass.error], rel=1e-9),
        "states": len(states.states_of(np.array([1.0, 1.1, 3.0]), np.array([0.05, 0.05, 0.1]))),
        "apart": [states.are_separated(1.0, 0.01, 1.0 + gap, 0.01) for gap in (0.05, 0.3, 1.0)],
    }
    assert GOLDEN["judging"] == judged
    energies = found.balance.energies
    measured = {
        "version": window.BALANCE_VERSION,
        "values": pytest.approx(
            [energies.work, energies.dissipated, energies.residual, found.balance.closure], rel=1e-6
        ),
        "frames": found.balance.frames,
    }
    assert GOLDEN["balance"] == measured
