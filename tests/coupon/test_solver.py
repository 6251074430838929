"""The real LIGGGHTS: physics with a closed form, and how it fails."""

import json
import os
import shutil
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import cycles, deck, log, runs, solver
from pidpanel.coupon.cases import cases_of
from pidpanel.coupon.solver import Liggghts
from pidpanel.study import Coupon

pytestmark = pytest.mark.liggghts


def coupon(**changes):
    values = {
        "cell": {"across_flats_mm": 6.35, "depth_mm": 10, "count": 2},
        "particles": {"diameter_mm": 2.5, "youngs_modulus_mpa": 50},
        "sweep": {"fill_fraction": [0.6], "frequency_hz": [100], "acceleration_g": [10]},
        "accuracy": {"relative_error": 0.5, "seeds": 1, "min_cycles": 10, "max_cycles": 10},
    }
    for key, value in changes.items():
        values[key] = {**values.get(key, {}), **value}
    return Coupon.model_validate(values)


@pytest.fixture(scope="module")
def bed_file(tmp_path_factory):
    """bed.json of a poured and loosened bed, with its fellows."""
    folder = tmp_path_factory.mktemp("bed")
    run = cases_of(coupon())[0].runs[0]
    packing = runs.attempt_pour(run.packing, folder / "packing")
    (folder / "packing" / "packing.json").write_text(json.dumps(packing))
    bed = runs.attempt_loosen(run.bed, folder / "packing" / "packing.json", folder / "bed")
    (folder / "bed" / "bed.json").write_text(json.dumps(bed))
    return folder / "bed" / "bed.json"


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
    runs._write_start(folder, run.packing, np.array([[0.0, 0.0, height]]))
    with Liggghts(folder, "shake") as process:
        process.execute(deck.render("shake.in.j2", runs.shake_values(run)))
        process.execute(f"velocity all set 0 0 {velocity}")
        process.execute(f"run {cycles_run * run.steps_per_cycle}")
        process.finish()
    rows = runs.read_run(run, folder, cycles_run)
    mass = run.packing.density * np.pi / 6 * run.packing.diameter**3
    return run, rows, mass


def test_a_ball_in_its_period_one_orbit_dissipates_what_the_closed_form_says(tmp_path):
    """P = ½ m (gT)² f (1 − e)/(1 + e): it lands once a period at the speed gT/(1 + e)·…"""
    e, frequency = 0.5, 50.0
    run, rows, mass = one_ball(
        tmp_path / "ball", frequency, 1.25, e, 0.3, 1e-3 + 0.2315e-3, -0.1191, 60
    )
    power = run.acceleration * rows[20:, 1].mean()  # ⟨a sin ωt · p⟩
    period = 1 / frequency
    closed_form = 0.5 * mass * (STANDARD_GRAVITY * period) ** 2 * frequency * (1 - e) / (1 + e)
    # the contact lasts 1 % of the period, so that much may be off; seen: 0.5 to 1 %
    assert power == pytest.approx(closed_form, rel=0.02)


def test_without_loss_in_the_contacts_nothing_is_dissipated(tmp_path):
    run, rows, mass = one_ball(tmp_path / "ball", 100.0, 5.0, 1.0, 0.0, 3e-3, 0.0, 200)
    energy = rows[:, log.CYCLE_COLUMNS.index("kinetic_energy")]
    work = run.acceleration * rows[:, 1] / run.frequency  # per cycle
    height = rows[:, log.CYCLE_COLUMNS.index("height")]
    # what the shaker put in is still there, as motion and height; the means over a cycle stand
    # for the values at its end, which is good to the energy of one cycle
    kept = energy[-1] - energy[0] + mass * STANDARD_GRAVITY * (height[-1] - height[0])
    assert abs(work.sum() - kept) < 2 * np.abs(np.diff(energy)).max() + 2 * np.abs(work).max()
    # and over many cycles far less than a ball of e = 0.5 would lose, half its energy a hit
    assert abs(work.sum()) < 0.1 * 200 * 0.5 * energy.mean() + 2 * energy.max()


def test_the_deck_a_run_leaves_runs_again_to_the_same_bits(tmp_path, bed_file):
    run = cases_of(coupon())[0].runs[0]
    outcome = runs.attempt_shake(run, bed_file, tmp_path / "run")
    assert outcome["status"] == "ok", outcome["message"]
    again = tmp_path / "again"
    again.mkdir()
    for name in ("shake.in", "start.data", "walls.stl"):
        shutil.copy(tmp_path / "run" / name, again)
    subprocess.run(
        ["liggghts", "-in", "shake.in"], cwd=again, check=True, stdout=subprocess.DEVNULL
    )
    assert (again / "cycles.txt").read_text() == (tmp_path / "run" / "cycles.txt").read_text()


def test_the_momentum_measure_is_the_work_of_the_walls(tmp_path, bed_file):
    """Newton's third law: the mean power from the momentum is wall force times wall velocity.

    In the frame of the cells the walls' forces on the spheres are the change of momentum less
    gravity and inertia; the shaker's power is that force times the velocity of the cells.
    """
    run = cases_of(coupon())[0].runs[0]
    runs._write_start(
        tmp_path / "run", run.packing,
        np.loadtxt(bed_file.with_name("bed.csv"), delimiter=",", skiprows=1),
    )  # fmt: skip
    count = 10
    extra = "variable fz equal fcm(all,z)\nfix trace all ave/time 1 1 5 v_p v_pull file trace.txt\n"
    with Liggghts(tmp_path / "run", "shake") as process:
        process.execute(
            deck.render("shake.in.j2", runs.shake_values(run)) + extra.split("\n", 1)[1]
        )
        process.execute(f"run {count * run.steps_per_cycle}")
        process.finish()
    rows = runs.read_run(run, tmp_path / "run", count)
    trace = np.loadtxt(tmp_path / "run" / "trace.txt")
    _, keep = np.unique(trace[:, 0], return_index=True)
    step, p, pull = trace[keep].T
    mass = len(np.loadtxt(bed_file.with_name("bed.csv"), delimiter=",", skiprows=1)) * (
        runs._sphere_mass(run.packing)
    )
    omega = 2 * np.pi * run.frequency
    t = step * run.time_step
    velocity = omega * run.amplitude * np.cos(omega * t)
    middle = 0.5 * (velocity[1:] + velocity[:-1])
    wall_impulse = np.diff(p) + mass * 0.5 * (pull[1:] + pull[:-1]) * np.diff(t)
    work = np.sum(wall_impulse * middle)
    by_momentum = run.acceleration * rows[:, 1].sum() / run.frequency
    # the momentum left at the ends of the run makes the difference p ẇ|ₑₙ𝒹, which is subtracted;
    # sampling of impacts every fifth step leaves 1 %
    ends = p[-1] * velocity[-1] - p[0] * velocity[0]
    assert work - ends == pytest.approx(by_momentum, rel=0.01)


def test_a_bed_below_onset_dissipates_next_to_nothing(tmp_path, bed_file):
    longer = {"min_cycles": 40, "max_cycles": 40}
    energy = []
    for level in (0.5, 5.0):
        run = cases_of(coupon(sweep={"acceleration_g": [level]}, accuracy=longer))[0].runs[0]
        outcome = runs.attempt_shake(run, bed_file, tmp_path / f"{level}")
        assert outcome["status"] == "ok", outcome["message"]
        rows = runs.read_run(run, tmp_path / f"{level}", outcome["cycles"])
        damping, _ = runs._harmonic(run, rows, outcome["spheres"])
        energy.append(cycles.dissipated_energy(damping[20:].mean(), run.amplitude, run.frequency))
    # per cycle and amplitude squared, E/W²: below Γ = 1 the bed never leaves the floor, and
    # what is left is elastic contact and the last of its settling; at 5 g it is thrown
    assert abs(energy[0]) / 0.5**2 < 0.1 * energy[1] / 5.0**2


def test_c_e_stays_below_the_inelastic_bound(tmp_path, bed_file):
    run = cases_of(coupon())[0].runs[0]
    outcome = runs.attempt_shake(run, bed_file, tmp_path / "s1")
    (tmp_path / "s1" / "run.json").write_text(json.dumps(outcome))
    row = runs.summarise(cases_of(coupon())[0], [tmp_path / "s1"])
    assert 0 < row["equivalent_damping_n_s_m3"] < row["bound_n_s_m3"]
    assert row["dissipated_energy_j_m2"] == pytest.approx(
        cycles.dissipated_energy(row["equivalent_damping_n_s_m3"], run.amplitude, run.frequency)
    )


def stop_when_running(folder, sig):
    """Send a signal to LIGGGHTS as soon as it has written a cycle."""
    script = (
        "import sys; from pathlib import Path\n"
        "from pidpanel.coupon.solver import Liggghts\n"
        "folder = Path(sys.argv[1])\n"
        "with Liggghts(folder, 'shake') as p:\n"
        "    print(p._process.pid, flush=True)\n"
        "    p.execute((folder / 'deck').read_text())\n"
        "    try:\n        p.execute('run 100000000')\n"
        "    except Exception as error:\n        print(type(error).__name__, error)\n"
    )
    child = subprocess.Popen(
        [sys.executable, "-c", script, str(folder)], stdout=subprocess.PIPE, text=True
    )
    pid = int(child.stdout.readline())
    deadline = time.monotonic() + 60
    while not (folder / "cycles.txt").exists() or not (folder / "cycles.txt").read_text():
        assert time.monotonic() < deadline, "LIGGGHTS wrote nothing within a minute"
        time.sleep(0.05)
    time.sleep(0.3)
    if sig is None:
        child.kill()
        child.wait()
    else:
        os.kill(pid, sig)
    return child, pid


@pytest.mark.parametrize(("sig", "status"), [(signal.SIGTERM, "0"), (signal.SIGKILL, "-9")])
def test_a_solver_killed_from_outside_is_a_stopped_run(tmp_path, bed_file, sig, status):
    run = cases_of(coupon())[0].runs[0]
    positions = np.loadtxt(bed_file.with_name("bed.csv"), delimiter=",", skiprows=1)
    runs._write_start(tmp_path / "run", run.packing, positions)
    (tmp_path / "run" / "deck").write_text(deck.render("shake.in.j2", runs.shake_values(run)))
    child, _ = stop_when_running(tmp_path / "run", sig)
    said = child.communicate(timeout=60)[0]
    # SIGTERM makes LIGGGHTS end its run early and go on as if nothing had happened
    assert "RunStopped" in said or f"exit status {status}" in said, said


def test_the_solver_dies_with_its_caller(tmp_path, bed_file):
    run = cases_of(coupon())[0].runs[0]
    positions = np.loadtxt(bed_file.with_name("bed.csv"), delimiter=",", skiprows=1)
    runs._write_start(tmp_path / "run", run.packing, positions)
    (tmp_path / "run" / "deck").write_text(deck.render("shake.in.j2", runs.shake_values(run)))
    _, pid = stop_when_running(tmp_path / "run", None)
    deadline = time.monotonic() + 10
    while Path(f"/proc/{pid}").exists() and "Z" not in _state(pid):
        assert time.monotonic() < deadline, "LIGGGHTS outlived its caller"
        time.sleep(0.05)


def _state(pid):
    try:
        return Path(f"/proc/{pid}/stat").read_text().rsplit(")", 1)[1].split()[0]
    except FileNotFoundError:
        return "Z"


def test_an_error_in_a_deck_is_told_in_the_solvers_words(tmp_path):
    with (
        Liggghts(tmp_path, "bad") as process,
        pytest.raises(log.RunStopped, match="exit status 1: ERROR: Unknown command"),
    ):
        process.execute("units si\nno_such_command 1")


def test_without_liggghts_the_message_says_what_to_install(monkeypatch, tmp_path):
    monkeypatch.setattr(solver, "COMMAND", "liggghts-that-is-not-there")
    with pytest.raises(log.SolverMissing, match="apt-get install liggghts"):
        Liggghts(tmp_path, "x")


def test_another_version_is_refused(monkeypatch, tmp_path):
    monkeypatch.setattr(solver, "VERSION", "9.9.9")
    with pytest.raises(log.SolverMissing, match=r"version 9\.9\.9 is wanted"):
        Liggghts(tmp_path, "x")


def test_a_failed_packing_is_handed_on_by_name(tmp_path):
    (tmp_path / "packing.json").write_text(
        json.dumps({"status": "UnderFilled", "message": "m", "attempts": 2, "liggghts": "3.8.0"})
    )
    run = cases_of(coupon())[0].runs[0]
    bed = runs.attempt_loosen(run.bed, tmp_path / "packing.json", tmp_path / "bed")
    (tmp_path / "bed.json").write_text(json.dumps(bed))
    outcome = runs.attempt_shake(run, tmp_path / "bed.json", tmp_path / "s1")
    assert outcome["status"] == "UnderFilled"
    (tmp_path / "s1").mkdir(exist_ok=True)
    (tmp_path / "s1" / "run.json").write_text(json.dumps(outcome))
    row = runs.summarise(cases_of(coupon())[0], [tmp_path / "s1"])
    assert row["status"] == "UnderFilled"
    assert np.isnan(row["equivalent_damping_n_s_m3"])


def test_a_fill_of_less_than_a_sphere_is_named(tmp_path, bed_file):
    packing = bed_file.parent.parent / "packing" / "packing.json"
    run = cases_of(coupon(sweep={"fill_fraction": [0.02]}))[0].runs[0]
    bed = runs.attempt_loosen(run.bed, packing, tmp_path / "bed")
    assert bed["status"] == "UnderFilled"
    assert "less than one of" in bed["message"]
