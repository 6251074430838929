"""The window of a run in which all contacts are listed, and its energy balance.

Nothing here enters a label. A run whose balance was measured by another version of the algorithm
(`BALANCE_VERSION`) keeps its rows and its balance is measured again.
"""

import math
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupon import balance, cycles, geometry, rows
from pidpanel.coupon.bed import Run
from pidpanel.coupon.liggghts import deck, output, start_files
from pidpanel.coupon.liggghts.failures import LogTruncated
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.coupon.packing import Packing
from pidpanel.coupon.records import MeasuredBalance, RunState

BALANCE_VERSION = 2  # of the algorithm that measures a balance: this module and `balance`

CLOSURE_LIMIT = 0.02  # share of the work that may be missing in the energy balance [1]

# Frames of the energy balance in an impact at the speed of the drive; the second where the
# first does not close. Listing every step instead changed the loss by 0.03 % (250 Hz, 20 g).
FRAMES_PER_CONTACT = (6, 24)

# A window with more frames, such as a slow cycle, has enough impacts for half the frames in each:
# at 30 Hz the loss changes by 0.3 %, its normal share by at most 0.0013.
ENOUGH_FRAMES = 1500

WINDOW = 2e-3  # shortest window of the energy balance [s]; one cycle where that is longer


def measure_balance(solver: Liggghts, run: Run, state: RunState, folder: Path) -> MeasuredBalance:
    """Return the energy balance over some cycles after the last of a run; see `balance`."""
    solver.end_rows(by_cell=run.cells_listed > 0)
    for per_contact in FRAMES_PER_CONTACT:
        measured = _window(solver, run, state, folder, per_contact)
        if abs(measured.closure) <= CLOSURE_LIMIT:
            break
    return measured


def _window(
    solver: Liggghts, run: Run, state: RunState, folder: Path, per_contact: int
) -> MeasuredBalance:
    drive, steps, spheres = run.drive, run.steps_per_cycle, state.spheres
    window = max(1, math.ceil(WINDOW * drive.frequency))
    stride = _frame_stride(run, window, per_contact)
    frames = window * steps // stride + 1
    rolling = run.constants.has_rolling_friction
    first, files = solver.list_contacts(window * steps, stride, rolling=rolling)
    motion = output.read_motion(files.motion.read_bytes(), str(files.motion), spheres=spheres)
    if len(motion.position) != frames:
        raise LogTruncated(f"{files.motion}: {len(motion.position)} of {frames} frames")
    planes = wall_planes(run.packing)
    pairs, touches = (
        output.read_contacts(
            path.read_text(errors="replace"),
            str(path),
            frames=frames,
            ids=(spheres, partners),
            with_wall=path is files.touches,
            rolling=rolling,
        )
        for path, partners in ((files.pairs, spheres), (files.touches, len(planes)))
    )
    for path in files:
        path.unlink()
    diameters = start_files.read_diameters((folder / deck.START_FILE).read_text())
    mass = geometry.masses(diameters, run.packing.density)
    # the second half of velocity Verlet, taken back
    kick = 0.5 * run.time_step / mass[:, None]
    twist = kick / (0.4 * (diameters[:, None] / 2) ** 2)
    phase = 2 * math.pi * (first + stride * np.arange(frames)) / steps
    measured = balance.energy_balance(
        balance.SphereFrames(
            radius=diameters / 2,
            mass=mass,
            position=motion.position,
            velocity=motion.velocity,
            spin=motion.spin,
            earlier_velocity=motion.velocity - kick * motion.force,
            earlier_spin=motion.spin - twist * motion.torque,
        ),
        pairs,
        touches,
        planes,
        run.constants.materials,
        drive.acceleration_at(phase),
        run.bed.gravity * np.array(run.bed.gravity_direction),
        stride * run.time_step,
    )
    # CLOSURE_LIMIT of this is the smallest required error of C_e
    smallest_error = rows.smallest_error(run, state.mass)
    smallest = cycles.dissipated_energy(smallest_error, drive.amplitude, drive.frequency)
    smallest_loss = float(smallest) / CLOSURE_LIMIT * window * run.packing.area
    size = max(abs(measured.work), measured.dissipated, smallest_loss)
    return MeasuredBalance(measured, measured.residual / size, window, frames)


def _frame_stride(run: Run, window: int, per_contact: int) -> int:
    """Return the steps between frames: ``per_contact`` in an impact, half in a long window."""
    steps = run.steps_per_cycle
    impact = run.contact_time_at(run.constants.youngs_modulus)
    stride = _stride(steps, impact / per_contact / run.time_step)
    if window * steps > ENOUGH_FRAMES * stride:
        enough = _stride(steps, window * steps / ENOUGH_FRAMES)
        stride = max(stride, min(enough, _stride(steps, 2 * impact / per_contact / run.time_step)))
    return stride


def wall_planes(packing: Packing) -> Array:
    """Return the planes (t, 4) of `geometry.closed_cells`: unit normal into the cell, offset.

    n·x = offset on the plane [m].
    """
    triangles = geometry.closed_cells(packing.outline, packing.centres, packing.depth)
    corner, along, up = np.moveaxis(triangles, 1, 0)
    normal = np.cross(along - corner, up - corner)
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    middle = np.column_stack([packing.centres, np.full(packing.count, packing.depth / 2)])
    cells = np.arange(packing.count)
    cell = np.concatenate([np.repeat(cells, len(packing.outline)), cells, cells])
    offset = (normal * corner).sum(axis=1)
    side = np.sign((normal * middle[cell]).sum(axis=1) - offset)
    return np.column_stack([side[:, None] * normal, side * offset])


def _stride(steps: int, longest: float) -> int:
    """Return the largest number of steps, at most ``longest``, that divides ``steps``."""
    return max(k for k in range(1, max(1, int(longest)) + 1) if steps % k == 0)
