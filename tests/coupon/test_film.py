"""A run that is watched goes on where it ended, and nothing it left is touched."""

from types import SimpleNamespace

import numpy as np
import pytest

from pidpanel.coupon import attempts, film, runs
from pidpanel.coupon.liggghts import output
from pidpanel.report import films
from tests.coupons import small_cases

pytestmark = pytest.mark.liggghts


@pytest.fixture(scope="module")
def left(tmp_path_factory):
    """A run of ten cycles, and the folder in which it was left."""
    folder = tmp_path_factory.mktemp("film")
    ten = {"relative_error": 0.5, "seeds": 1, "min_cycles": 10, "max_cycles": 10, "min_time_s": 0}
    sweep = {"fill_fraction": [0.6], "frequency_hz": [100]}
    (case,) = small_cases(cell={"count": 2}, sweep=sweep, accuracy=ten)
    run, bed = case.runs[0], folder / "bed" / "bed.json"
    attempts.pour_packing(run.packing, folder / "packing" / "packing.json")
    attempts.loosen_bed(run.bed, folder / "packing" / "packing.json", bed)
    outcome = attempts.shake_run(run, case.target, bed, folder / "run")
    assert outcome.status == "ok", outcome.message
    return run, folder / "run"


def test_the_frames_go_on_where_the_run_ended(left):
    run, folder = left
    before = {file.name: file.read_bytes() for file in folder.iterdir()}
    shot = film.watch(run, folder, cycles=2, frames=24)
    assert {file.name: file.read_bytes() for file in folder.iterdir()} == before
    assert 48 <= len(shot.time) <= 50
    assert shot.time[-1] == pytest.approx(2 / run.drive.frequency, rel=1 / 24)
    assert shot.position.shape == shot.velocity.shape == (len(shot.time), len(shot.diameters), 3)
    assert shot.diameters == pytest.approx(2.5e-3)
    # the first frame is that of the end, but for the steps to the first dump
    last = output.read_dump(
        (folder / runs.last_file(10)).read_text(), "last", output.POSITION_AND_VELOCITY
    )[-1]
    fastest = np.abs(shot.velocity).max()
    # 1e-6 m: a dump has six digits of some centimetres
    assert np.abs(shot.position[0] - last[:, :3]).max() <= 2 * fastest * shot.time[0] + 1e-6
    # velocities are those of the positions; contacts are far shorter than a frame
    step = np.diff(shot.position, axis=0)
    run_by = (shot.velocity[1:] + shot.velocity[:-1]) / 2 * np.diff(shot.time)[:, None, None]
    assert np.median(np.abs(step - run_by)) < 0.2 * np.median(np.abs(step))


def test_a_run_without_its_restart_is_not_watched(left, tmp_path):
    run, folder = left
    assert film.watch(run, tmp_path, cycles=1, frames=24) is None
    state = folder / film.RunState.read(folder).restart
    away = state.rename(tmp_path / "away")
    assert film.watch(run, folder, cycles=1, frames=24) is None
    away.rename(state)


def test_a_run_that_is_not_watched_leaves_a_file_that_can_be_read(tmp_path, monkeypatch):
    table = tmp_path / "cases.csv"
    table.write_text("case,status,fill_fraction,frequency_hz,acceleration_g\nc,ok,0.5,100,10\n")
    case = SimpleNamespace(point=None, folders=lambda folder: [folder])
    monkeypatch.setattr(films, "watch", lambda *a, **k: None)  # as of a deck of the user's own
    films.write_film({"c": case}, {"version": "1"}, table, tmp_path, tmp_path / "film.nc")
    assert films.read_film({"c": case}, tmp_path / "film.nc") is None
