"""The real LIGGGHTS: physics with a closed form, and how it fails."""

import dataclasses
import json
import pickle
import shutil
import signal
import subprocess
import sys

import numpy as np
import pytest

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import (
    attempts,
    cycles,
    geometry,
    preparation,
    records,
    rows,
    runs,
    summary,
    window,
)
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.liggghts import failures, output
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.paths import TEMPLATES
from pidpanel.study.coupon import Coupon
from tests.coupons import SMALL, with_changes

pytestmark = pytest.mark.liggghts


def coupon(**changes):
    ten = {"relative_error": 0.5, "seeds": 1, "min_cycles": 10, "max_cycles": 10, "min_time_s": 0}
    values = with_changes(
        SMALL,
        {"cell": {"count": 2}, "sweep": {"fill_fraction": [0.6], "frequency_hz": [100]},
         "accuracy": ten},
    )  # fmt: skip
    return Coupon.model_validate(with_changes(values, changes))


@pytest.fixture(scope="module")
def bed_file(tmp_path_factory):
    """bed.json of a poured and loosened bed, with its fellows."""
    folder = tmp_path_factory.mktemp("bed")
    run = cases_of(coupon())[0].runs[0]
    packing, bed = folder / "packing" / "packing.json", folder / "bed" / "bed.json"
    attempts.pour_packing(run.packing, packing)
    attempts.loosen_bed(run.bed, packing, bed)
    return bed


def shaken(folder, bed_file, **changes):
    """Row of cases.csv of the one case of a coupon, and its run."""
    (case,) = cases_of(coupon(**changes))
    outcome = attempts.shake_run(case.runs[0], case.target, bed_file, case.folders(folder)[0])
    assert outcome.status == "ok", outcome.message
    records.write(case.outcome_file(folder), records.CaseOutcome((outcome,)))
    return summary.summarise(case, *summary.read_seeds(case, folder)), case.runs[0]


def one_ball(folder, frequency, level, restitution, friction, height, velocity, cycles_run):
    """A ball on a shaken plate: cycle rows of the shake deck, its mass and the drive."""
    study = coupon(
        cell={"depth_mm": 100, "count": 1, "across_flats_mm": 20},
        particles={
            "diameter_mm": 2.0, "density_kg_m3": 1180, "youngs_modulus_mpa": 500,
            "restitution": restitution, "friction": friction,
        },
        sweep={"frequency_hz": [frequency], "acceleration_g": [level]},
    )  # fmt: skip
    run = cases_of(study)[0].runs[0]
    preparation.write_start(folder, run.packing, np.array([[0.0, 0.0, height, 2e-3]]))
    with Liggghts(folder, "shake") as solver:
        solver.read_deck(run.deck_text())
        solver.set_velocity(0.0, 0.0, velocity)
        solver.run(cycles_run * run.steps_per_cycle)
        solver.finish()
    read = rows.read_rows(run, folder, [cycles_run], cycles_run)
    mass = run.packing.density * np.pi / 6 * run.packing.diameter**3
    return run, read, mass


def test_without_loss_in_the_contacts_nothing_is_dissipated(tmp_path):
    run, read, mass = one_ball(tmp_path / "ball", 100.0, 5.0, 1.0, 0.0, 3e-3, 0.0, 30)
    energy = read[:, output.CYCLE_COLUMNS.index("kinetic_energy")]
    work = run.drive.acceleration * read[:, 1] / run.drive.frequency  # per cycle
    height = read[:, output.CYCLE_COLUMNS.index("height")]
    # what the shaker put in is still there, as motion and height; the means over a cycle are taken
    # for the values at its end, which is good to the energy of one cycle
    kept = energy[-1] - energy[0] + mass * STANDARD_GRAVITY * (height[-1] - height[0])
    assert abs(work.sum() - kept) < 2 * np.abs(np.diff(energy)).max() + 2 * np.abs(work).max()
    # and over many cycles far less than a ball of e = 0.5 would lose, half its energy a hit
    assert abs(work.sum()) < 0.1 * 30 * 0.5 * energy.mean() + 2 * energy.max()


def test_the_deck_a_run_leaves_runs_again_to_the_same_bits(tmp_path, bed_file):
    (case,) = cases_of(coupon())
    outcome = attempts.shake_run(case.runs[0], case.target, bed_file, tmp_path / "run")
    assert outcome.status == "ok", outcome.message
    again = tmp_path / "again"
    again.mkdir()
    for name in ("shake_1.in", "start.data", "walls.stl"):
        shutil.copy(tmp_path / "run" / name, again)
    subprocess.run(
        ["liggghts", "-in", "shake_1.in"], cwd=again, check=True, stdout=subprocess.DEVNULL
    )
    first, second = (f / "cycles_1.txt" for f in (tmp_path / "run", again))
    assert first.read_text() == second.read_text()


def test_the_momentum_measure_is_the_work_of_the_walls(tmp_path, bed_file):
    """Newton's third law: the mean power from the momentum is wall force times wall velocity.

    In the frame of the cells the walls' forces on the spheres are the change of momentum less
    gravity and inertia; the shaker's power is that force times the velocity of the cells.
    """
    run = cases_of(coupon())[0].runs[0]
    spheres = preparation.read_bed(bed_file.parent)
    preparation.write_start(tmp_path / "run", run.packing, spheres)
    count = 10
    trace = "fix trace all ave/time 1 1 5 v_p v_inertia file trace.txt\n"
    with Liggghts(tmp_path / "run", "shake") as solver:
        solver.read_deck(run.deck_text() + trace)
        solver.run(count * run.steps_per_cycle)
        solver.finish()
    read = rows.read_rows(run, tmp_path / "run", [count], count)
    trace = np.loadtxt(tmp_path / "run" / "trace.txt")
    _, keep = np.unique(trace[:, 0], return_index=True)
    step, p, inertia = trace[keep].T
    pull = STANDARD_GRAVITY - inertia
    mass = geometry.masses(spheres[:, 3], run.packing.density).sum()
    omega = run.drive.angular_frequency
    t = step * run.time_step
    velocity = omega * run.drive.amplitude * np.cos(omega * t)
    middle = 0.5 * (velocity[1:] + velocity[:-1])
    wall_impulse = np.diff(p) + mass * 0.5 * (pull[1:] + pull[:-1]) * np.diff(t)
    work = np.sum(wall_impulse * middle)
    by_momentum = run.drive.acceleration * read[:, 1].sum() / run.drive.frequency
    # the momentum left at the ends of the run makes the difference p ẇ|ₑₙ𝒹, which is subtracted;
    # sampling of impacts every fifth step leaves 1 %
    ends = p[-1] * velocity[-1] - p[0] * velocity[0]
    assert work - ends == pytest.approx(by_momentum, rel=0.01)


def test_a_bed_below_onset_dissipates_next_to_nothing(tmp_path, bed_file):
    longer = {"min_cycles": 24, "max_cycles": 24}
    energy = []
    for level in (0.5, 5.0):
        (case,) = cases_of(coupon(sweep={"acceleration_g": [level]}, accuracy=longer))
        run = case.runs[0]
        found = attempts.shake_run(run, case.target, bed_file, tmp_path / f"{level}").product
        read = rows.read_rows(run, tmp_path / f"{level}", found.legs, found.cycles)
        damping, _ = rows.harmonic(run, read, found.mass_kg)
        drive = run.drive
        energy.append(
            cycles.dissipated_energy(damping[12:].mean(), drive.amplitude, drive.frequency)
        )
    # per cycle and amplitude squared, E/W²: below Γ = 1 the bed never leaves the floor, and
    # what is left is elastic contact and the last of its settling; at 5 g it is thrown
    assert abs(energy[0]) / 0.5**2 < 0.1 * energy[1] / 5.0**2


def test_c_e_stays_below_the_inelastic_bound(tmp_path, bed_file):
    row, run = shaken(tmp_path, bed_file)
    assert 0 < row["equivalent_damping_n_s_m3"] < row["bound_n_s_m3"]
    assert row["dissipated_energy_j_m2"] == pytest.approx(
        cycles.dissipated_energy(
            row["equivalent_damping_n_s_m3"], run.drive.amplitude, run.drive.frequency
        )
    )


def test_seeds_that_are_apart_go_on_until_they_agree_or_to_the_end(tmp_path, monkeypatch):
    limits = {"relative_error": 0.5, "min_cycles": 10, "max_cycles": 20}
    (case,) = cases_of(coupon(cell={"count": 1}, accuracy={**limits, "seeds": 2}))
    asked = []

    def cycles_of(apart):
        monkeypatch.setattr(attempts, "seeds_disagree", lambda found: asked.append(found) or apart)
        outcomes = attempts.shake_seeds(case, case.target, tmp_path)
        assert {o.status for o in outcomes} == {"ok"}
        return [o.product.cycles for o in outcomes]

    assert cycles_of(apart=False) == [10, 10]
    assert cycles_of(apart=True) == [20, 20]
    # 10 and 10, then in turn 15, 20
    assert len(asked) == 1 + 4


def test_seeds_are_apart_beyond_a_quarter_of_their_mean_and_four_errors():
    def apart(*values):
        return attempts.seeds_disagree(
            [cycles.Estimate(mean, error, 0, 10, 0.0) for mean, error in values]
        )

    assert apart((202, 4), (1243, 71))
    assert not apart((2644, 24), (2517, 19))  # ten errors, but one twentieth
    assert not apart((12369, 1500), (19290, 1500))  # a third, but three errors


def test_a_failed_packing_is_handed_on_by_name(tmp_path):
    (case,) = cases_of(coupon())
    run = case.runs[0]
    failed = records.Outcome("UnderFilled", "m", None)
    records.write(tmp_path / "packing.json", failed)
    attempts.loosen_bed(run.bed, tmp_path / "packing.json", tmp_path / "bed.json")
    outcome = attempts.shake_run(run, case.target, tmp_path / "bed.json", tmp_path / "s1")
    assert (outcome.status, outcome.message) == ("UnderFilled", "m")
    records.write(case.outcome_file(tmp_path), records.CaseOutcome((outcome,)))
    row = summary.summarise(case, *summary.read_seeds(case, tmp_path))
    assert row["status"] == "UnderFilled"
    assert np.isnan(row["equivalent_damping_n_s_m3"])


# ------------------------------------------------------------------ going on from a restart


def test_a_tighter_target_goes_on_from_the_restart_and_the_looser_one_still_reads_the_same(
    tmp_path, bed_file
):
    short, _ = shaken(tmp_path, bed_file)
    long, run = shaken(tmp_path, bed_file, accuracy={"min_cycles": 24, "max_cycles": 24})
    folder = next(tmp_path.glob("r*/s1"))
    state = json.loads((folder / "state.json").read_text())
    assert state["legs"] == [10, 14]  # nothing was run twice
    assert (long["cycles_run"], short["cycles_run"]) == (24, 10)
    again, _ = shaken(tmp_path, bed_file)
    assert json.loads((folder / "state.json").read_text()) == state
    assert again == short
    # and the two legs are one run: in one process, stopped at the same cycle, the same bits
    limits = {"min_cycles": 10, "max_cycles": 15, "relative_error": 1e-6}
    (case,) = cases_of(coupon(accuracy=limits))
    attempts.shake_run(case.runs[0], case.target, bed_file, tmp_path / "one")
    whole = rows.read_rows(run, tmp_path / "one", [15], 15)
    parts = rows.read_rows(run, folder, state["legs"], 15)
    np.testing.assert_array_equal(whole, parts)


LONG = {"min_cycles": 10, "max_cycles": 40, "relative_error": 1e-6}


@pytest.mark.parametrize("sig", [signal.SIGTERM, signal.SIGKILL])
def test_a_run_killed_on_its_way_is_tried_again_from_its_restart_to_the_same_bits(
    tmp_path, bed_file, sig
):
    (case,) = cases_of(coupon(accuracy=LONG))
    run, folder = case.runs[0], tmp_path / "killed"
    # LIGGGHTS is killed once, when it has left its first restart
    script = (
        "import os, pickle, sys; from pathlib import Path\n"
        "from pidpanel.coupon import attempts, records\n"
        "case, bed, folder, sig = sys.argv[1:]\n"
        "write = records.RunState.write\n"
        "def write_and_kill(state, folder):\n"
        "    write(state, folder)\n"
        "    records.RunState.write = write\n"
        "    pid = os.getpid()\n"
        "    (solver,) = Path(f'/proc/{pid}/task/{pid}/children').read_text().split()\n"
        "    os.kill(int(solver), int(sig))\n"
        "records.RunState.write = write_and_kill\n"
        "case = pickle.loads(bytes.fromhex(case))\n"
        "outcome = attempts.shake_run(case.point, case.target, Path(bed), Path(folder))\n"
        "records.write(Path(folder, 'outcome.json'), outcome)\n"
    )
    child = subprocess.run(
        [sys.executable, "-c", script, pickle.dumps(case).hex(), bed_file, folder, str(int(sig))],
        stderr=subprocess.PIPE, text=True, check=True,
    )  # fmt: skip
    outcome = records.read(records.Outcome[records.Shaken], folder / "outcome.json")
    assert (outcome.status, child.stderr.count("tried again")) == ("ok", 1)
    assert outcome.product.cycles == 40
    assert outcome.product.legs == (10, 30)
    whole = attempts.shake_run(run, case.target, bed_file, tmp_path / "whole")
    np.testing.assert_array_equal(
        rows.read_rows(run, folder, outcome.product.legs, 40),
        rows.read_rows(run, tmp_path / "whole", whole.product.legs, 40),
    )


def test_a_failure_that_stays_is_reported_after_the_second_attempt(tmp_path, bed_file):
    (case,) = cases_of(coupon())
    # spheres so fast that they leave the cell within a step
    run = dataclasses.replace(case.runs[0], time_step=3e-3)
    try:
        outcome = attempts.shake_run(run, case.target, bed_file, tmp_path / "lost")
    except failures.RunStopped as failure:  # LIGGGHTS ends itself: the job fails
        assert "shake_1" in str(failure)
    else:
        assert outcome.status in ("ParticlesLost", "NotFinite")
        assert "shake_1" in outcome.message or "cycles_1" in outcome.message


def test_rows_after_the_last_restart_do_not_count(tmp_path, bed_file):
    shaken(tmp_path, bed_file)
    folder = next(tmp_path.glob("r*/s1"))
    file = folder / "cycles_1.txt"
    before = file.read_text()
    # what a process killed on its way to a next restart would have left
    file.write_text(before + before.splitlines()[-1].replace("10000", "11000") + "\n")
    row, _ = shaken(tmp_path, bed_file, accuracy={"min_cycles": 12, "max_cycles": 12})
    assert file.read_text() == before
    assert row["cycles_run"] == 12


def test_the_energy_of_a_run_closes_and_is_split(tmp_path, bed_file):
    row, _ = shaken(tmp_path, bed_file)
    # 1 % was seen at 0.15 Rayleigh times, and 2 % is what a run may miss
    assert abs(row["closure"]) < window.CLOSURE_LIMIT
    assert row["normal_share"] + row["tangential_share"] == pytest.approx(1)
    assert 0.2 < row["normal_share"] < 0.8


def balance_with(folder, bed_file, **constants):
    """Energy balance of the run with other contacts of spheres and walls than in its bed."""
    (case,) = cases_of(coupon())
    walls = {f"wall_{name}": value for name, value in constants.items()}
    other = dataclasses.replace(case.runs[0].constants, **constants, **walls)
    run = dataclasses.replace(case.runs[0], constants=other)
    return runs.shake(run, case.target, bed_file.parent, folder / "other").balance


def test_without_friction_all_is_lost_along_the_normal(tmp_path, bed_file):
    found = balance_with(tmp_path, bed_file, friction=0.0)
    energies = found.energies
    normal = energies.sphere_normal + energies.wall_normal
    assert abs(energies.sphere_tangential + energies.wall_tangential) < 1e-9 * normal
    assert abs(found.closure) < window.CLOSURE_LIMIT


def test_rolling_friction_has_its_place_in_the_balance(tmp_path, bed_file):
    found = balance_with(tmp_path, bed_file, rolling_friction=0.2)
    assert found.energies.rolling > 0.02 * found.energies.work
    assert abs(found.closure) < window.CLOSURE_LIMIT


@pytest.mark.parametrize(("restitution", "friction"), [(0.34, 0.7), (0.6, 0.05)])
def test_the_energy_closes_at_low_restitution_and_high_friction(
    tmp_path, bed_file, restitution, friction, monkeypatch
):
    # −0.27 and −0.16 % of the work with every step listed; −11 % at (0.34, 0.7) while contacts that
    # stick were cut back to Coulomb's limit, which LIGGGHTS does not do
    monkeypatch.setattr(window, "FRAMES_PER_CONTACT", (24,))
    found = balance_with(tmp_path, bed_file, restitution=restitution, friction=friction)
    assert abs(found.closure) < 0.005


def test_the_energy_closes_where_restitution_falls_with_the_speed(tmp_path, bed_file, monkeypatch):
    monkeypatch.setattr(window, "FRAMES_PER_CONTACT", (24,))
    law = {"restitution": {"value": 0.6, "at_m_s": 0.1, "law": "viscoelastic"}}
    impacts = cases_of(coupon(particles=law))[0].point.constants.impacts
    (case,) = cases_of(coupon())
    constants = dataclasses.replace(
        case.runs[0].constants, restitution=0.6, wall_restitution=0.6, impacts=impacts
    )
    run = dataclasses.replace(case.runs[0], constants=constants)
    found = runs.shake(run, case.target, bed_file.parent, tmp_path / "other").balance
    assert abs(found.closure) < 0.005


# ------------------------------------------------------------------ judged anew


def test_another_version_of_the_balance_measures_it_anew_and_runs_no_cycle_again(
    tmp_path, bed_file, monkeypatch
):
    first, _ = shaken(tmp_path, bed_file)
    folder = next(tmp_path.glob("r*/s1"))
    before = {name: (folder / name).stat().st_mtime_ns for name in ("cycles_1.txt", "shake_1.log")}
    again, _ = shaken(tmp_path, bed_file)
    assert again == first
    assert not (folder / "shake_2.log").exists()  # all was there
    monkeypatch.setattr(window, "BALANCE_VERSION", 1000)
    anew, _ = shaken(tmp_path, bed_file)
    assert (folder / "shake_2.log").exists()
    assert {name: (folder / name).stat().st_mtime_ns for name in before} == before
    state = records.RunState.read(folder)
    assert (state.legs, state.balance_version) == ((10,), 1000)
    # from a restart at the cycle at which it was measured before: the same bits
    assert anew == first


def test_a_deck_of_the_users_own_begins_anew_only_for_more_cycles(tmp_path, bed_file):
    own = {"deck": TEMPLATES / "shake_lab.in.j2"}
    values = coupon().model_dump(mode="python", by_alias=True) | own

    def run_to(cycles_run):
        accuracy = values["accuracy"] | {"min_cycles": cycles_run, "max_cycles": cycles_run}
        (case,) = cases_of(Coupon.model_validate(values | {"accuracy": accuracy}))
        folder = case.folders(tmp_path)[0]
        found = runs.shake(case.point, case.target, bed_file.parent, folder)
        return found, (folder / "cycles_1.txt").stat().st_mtime_ns

    found, written = run_to(10)
    assert (found.legs, found.balance) == ((10,), None)  # that deck lists no contacts
    assert run_to(10) == (found, written)
    assert run_to(12)[0].legs == (12,)


def test_a_folder_that_cannot_be_written_is_named(tmp_path, bed_file):
    (tmp_path / "file").write_text("no folder")
    (case,) = cases_of(coupon())
    with pytest.raises(OSError, match=str(tmp_path / "file")):
        attempts.shake_run(case.point, case.target, bed_file, tmp_path / "file" / "s1")
