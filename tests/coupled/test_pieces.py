"""Real LIGGGHTS: a run that was stopped goes on to the same bits, and damage begins it anew."""

import numpy as np
import pytest

from pidpanel.coupled import beds, pieces
from pidpanel.coupled.checkpoints import FILE
from pidpanel.coupled.integration import Integration
from pidpanel.coupon.liggghts.failures import RunStopped

MODULUS, ROWS, SUBSTEPS, INTERVALS = 50e6, 300, 4, 4

pytestmark = pytest.mark.liggghts


@pytest.fixture
def run(bed, plate, monkeypatch):
    """A run of 24 ms in three pieces, as a function of its folder; the bed is thrown at its lid."""
    found, folder = bed
    packing = found.packing
    step = 0.2 * packing.smallest(MODULUS).rayleigh_time
    rng = np.random.default_rng(1)
    force = 200.0 * rng.standard_normal((ROWS + 1, plate.count))
    start = np.stack([np.zeros(plate.count), rng.standard_normal(plate.count)])
    cells = np.full(8, packing.cell_area)
    shapes = plate.modal, plate.at_cells, plate.at_points
    whole = Integration(*shapes, plate.area, cells, force, step, SUBSTEPS, INTERVALS, 50)
    started = beds.started(found, MODULUS, folder)
    of_row = pieces.cpu_per_row(whole, [started.spheres])
    monkeypatch.setattr(pieces, "PIECE_S", 100 * of_row)

    def recorded(where):
        rows, balance = pieces.integrated("run", whole, start, [started], where)
        found = plate.recorded(whole, rows, whole.begin(start))
        found.balance = balance
        return found

    return recorded


def same(one, other):
    return all(
        np.array_equal(getattr(one, name), getattr(other, name))
        for name in ("at_cells", "at_points", "impulse")
    )


def stopped(run, folder, monkeypatch, after):
    """Stop a run after so many pieces."""
    done, in_child = [], pieces.in_child

    def dies(*of, **more):
        if len(done) == after:
            raise RunStopped("killed")
        done.append(1)
        return in_child(*of, **more)

    with monkeypatch.context() as patch:
        patch.setattr(pieces, "in_child", dies)
        with pytest.raises(RunStopped):
            run(folder)


def test_a_stopped_run_goes_on_to_the_same_bits(run, tmp_path, monkeypatch, capsys):
    undisturbed = run(tmp_path / "one")
    # the spheres have hit the walls in every piece
    pushed = np.diff(undisturbed.impulse, axis=0).reshape(-1, 8)
    assert all(np.ptp(part, axis=0).min() > 0 for part in np.array_split(pushed, 3))
    stopped(run, tmp_path / "two", monkeypatch, 2)
    again = run(tmp_path / "two")
    assert f"resumed at {2 / 3:.0%}" in capsys.readouterr().err
    assert same(again, undisturbed)
    assert again.balance == undisturbed.balance
    assert len(list((tmp_path / "two").glob("*.restart"))) == 1
    # and as in one piece, until LIGGGHTS sorts its neighbours anew and sums in another order
    monkeypatch.setattr(pieces, "PIECE_S", 1000.0)
    smooth = run(tmp_path / "smooth")
    given = np.diff([undisturbed.impulse, smooth.impulse], axis=1)
    apart = np.abs(given[0] - given[1])
    assert apart[98:104].max() < 1e-9 * np.abs(given).max()
    assert apart.max() > 0


def test_a_damaged_checkpoint_is_not_believed(run, tmp_path, monkeypatch, capsys):
    folder = tmp_path / "run"
    stopped(run, folder, monkeypatch, 1)
    restart, state = *folder.glob("*.restart"), folder / FILE
    kept = state.read_bytes(), restart.read_bytes()
    whole = bytearray(kept[1])
    whole[len(whole) // 2] ^= 1
    for path, content in ((restart, bytes(whole)), (state, kept[0][:-1000])):
        state.write_bytes(kept[0])
        restart.write_bytes(kept[1])
        path.write_bytes(content)
        stopped(run, folder, monkeypatch, 0)
        said = capsys.readouterr().err
        assert "restarted from the beginning" in said
        assert "resumed at" not in said


def test_other_bits_of_a_run_need_another_integration_version(run, tmp_path):
    row = 100
    record = run(tmp_path)
    impulse = record.impulse[row]
    assert pieces.INTEGRATION_VERSION == 1
    assert [impulse.sum(), (impulse**2).sum(), *record.at_points[row]] == pytest.approx(
        [-12.971627898105332, 80.1774583469781, 0.00033585350340691115, 0.0009130323049896234],
        rel=1e-7,
    )
