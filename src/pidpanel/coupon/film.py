"""A run watched for some cycles: where its spheres are, from the last restart on.

Nothing that is counted is touched: the watched cycles come after those of the rows, in a folder of
their own.
"""

import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupon.bed import Run
from pidpanel.coupon.liggghts import deck, output, start_files
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.coupon.records import RunState

FRAMES_FILE = "frames.dump"


@dataclass(frozen=True)
class Film:
    """The spheres of a run in some frames at equal intervals, the first at phase 0 of the drive."""

    time: Array  # since the first frame [s], shape ``(n_frames,)``
    position: Array  # centres seen from the cells [m], shape ``(n_frames, n, 3)``
    velocity: Array  # velocities seen from the cells [m/s], shape ``(n_frames, n, 3)``
    diameters: Array  # diameters [m], shape ``(n,)``


def watch(run: Run, folder: Path, *, cycles: int, frames: int) -> Film | None:
    """Run some more cycles of a run and return its spheres; the folder stays as it is.

    Parameters
    ----------
    run
        The run; its deck is that of pidpanel.
    folder
        Folder of the run from `runs.shake`.
    frames
        Approximate number of frames in a cycle: a whole number of steps is between two.

    Returns
    -------
    Film or None
        None where there is no restart to begin from, and for a deck of the user's own, of which
        a restart need not hold everything.

    Raises
    ------
    SolverFailure
        If the run fails; the class is the reason.
    """
    state = RunState.read(folder)
    if state is None or state.run != run.identity or not state.restart or run.deck is not None:
        return None
    if not (folder / state.restart).is_file():
        return None
    stride = max(1, run.steps_per_cycle // frames)
    columns = output.POSITION_AND_VELOCITY
    with tempfile.TemporaryDirectory(dir=folder) as name:
        scratch = Path(name)
        for needed in (deck.START_FILE, deck.WALLS_FILE, state.restart):
            shutil.copy(folder / needed, scratch)
        with Liggghts(scratch, "film") as solver:
            solver.read_deck(run.deck_text(1, state.restart))
            first = solver.instant().step
            count = cycles * run.steps_per_cycle // stride
            solver.run_and_dump(count * stride, stride, FRAMES_FILE, columns)
            solver.finish(first + count * stride, state.spheres)
        file = scratch / FRAMES_FILE
        read = output.read_dump(file.read_text(), str(file), columns)
    diameters = start_files.read_diameters((folder / deck.START_FILE).read_text())
    # LIGGGHTS dumps at multiples of `stride`: the first of them may lie after the start
    begun = -(-first // stride) * stride
    time = np.arange(len(read), dtype=float) * (stride * run.time_step)
    time += (begun - first) * run.time_step
    return Film(time, read[..., :3], read[..., 3:], diameters)
