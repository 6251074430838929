"""The window of a run in which all contacts are listed, and its energy balance."""

from __future__ import annotations

import math
from dataclasses import asdict
from pathlib import Path

import numpy as np

from pidpanel.coupon import balance, cycles, geometry
from pidpanel.coupon.cases import Run
from pidpanel.coupon.liggghts import output
from pidpanel.coupon.liggghts.process import Liggghts
from pidpanel.coupon.preparation import read_diameters, wall_planes

CLOSURE_LIMIT = 0.02
"""Share of the work that may be missing in the energy balance."""

FRAMES_PER_CONTACT = (6, 24)
"""Frames of the energy balance in an impact at the speed of the drive; the second where the
first does not close. Listing every step instead changed the loss by 0.03 % (250 Hz, 20 g)."""

ENOUGH_FRAMES = 1500
"""A window of more frames, which a slow cycle is, has so many impacts that half the frames in
each will do: at 30 Hz the loss moves by 0.3 %, its normal share by 0.0013 at the most."""

WINDOW = 2e-3
"""Shortest window of the energy balance, s; one cycle where that is longer."""

BALANCE_COLUMNS = (
    *("x", "y", "z", "vx", "vy", "vz"),
    *("omegax", "omegay", "omegaz", "fx", "fy", "fz"),
)
"""Of each sphere in every frame of the energy balance, SI."""


def measure_balance(
    solver: Liggghts, run: Run, spheres: int, floor: float, folder: Path
) -> dict[str, float]:
    """Energy balance over some cycles after the last of a run; see `balance`.

    Parameters
    ----------
    solver
        At the last cycle of the run; its cycle file is closed here.
    spheres
        In all cells.
    floor
        The smallest error of C_e that is asked for, N s/m³; see `runs.FLOOR`.
    folder
        Of the run.

    Returns
    -------
    dict
        The energies of `balance.Balance` in J, ``closure`` (the residual over the work),
        ``cycles`` and ``frames`` of the window.
    """
    solver.execute("unfix cycle")
    for per_contact in FRAMES_PER_CONTACT:
        found = _window(solver, run, spheres, floor, folder, per_contact)
        if abs(found["closure"]) <= CLOSURE_LIMIT:
            break
    return found


def _window(
    solver: Liggghts, run: Run, spheres: int, floor: float, folder: Path, per_contact: int
) -> dict[str, float]:
    packing, constants = run.packing, run.constants
    steps = run.steps_per_cycle
    impact = run.contact_time_at(constants.youngs_modulus)
    window = max(1, math.ceil(WINDOW * run.frequency))
    stride = _stride(steps, impact / per_contact / run.time_step)
    if window * steps > ENOUGH_FRAMES * stride:
        enough = _stride(steps, window * steps / ENOUGH_FRAMES)
        stride = max(stride, min(enough, _stride(steps, 2 * impact / per_contact / run.time_step)))
    rolling = bool(constants.rolling_friction or constants.wall_rolling_friction)
    pairs, touches, moving = (folder / n for n in ("pairs.dump", "touches.dump", "spheres.bin"))
    first, _, _ = solver.execute(
        f"dump pairs all local {stride} {pairs.name} {_columns('pairs', (1, 2), rolling)}\n"
        f"dump touches all local {stride} {touches.name} {_columns('touches', (2, 3), rolling)}\n"
        f"dump spheres all custom {stride} {moving.name} id {' '.join(BALANCE_COLUMNS)}\n"
        "dump_modify spheres sort id"
    )
    solver.execute(f"run {window * steps}\nundump pairs\nundump touches\nundump spheres")
    motion = output.read_binary_dump(
        moving.read_bytes(), str(moving), atoms=spheres, columns=1 + len(BALANCE_COLUMNS)
    )
    (pair_frame, pair), (touch_frame, touch) = (
        output.read_local_dump(
            path.read_text(), str(path), frames=len(motion), columns=8 if rolling else 5
        )
        for path in (pairs, touches)
    )
    for path in (pairs, touches, moving):
        path.unlink()
    diameters = read_diameters((folder / "start.data").read_text())
    phase = 2 * math.pi * (first + stride * np.arange(len(motion))) / steps
    moduli = (constants.youngs_modulus, constants.wall_youngs_modulus)
    ratios = (constants.poissons_ratio, constants.wall_poissons_ratio)
    mass = geometry.masses(diameters, packing.density)
    velocity, force = motion[:, :, 4:7], motion[:, :, 10:13]
    found = balance.energy_balance(
        balance.Spheres(
            radius=diameters / 2,
            mass=mass,
            position=motion[:, :, 1:4],
            velocity=velocity,
            spin=motion[:, :, 7:10],
            # the second half of velocity Verlet, taken back
            earlier_velocity=velocity - 0.5 * run.time_step * force / mass[:, None],
        ),
        balance.Contacts(
            pair_frame,
            pair[:, 0].astype(int) - 1,
            pair[:, 1].astype(int) - 1,
            pair[:, 2:5],
            pair[:, 5:8] if rolling else None,
        ),
        balance.Contacts(
            touch_frame,
            touch[:, 1].astype(int) - 1,
            touch[:, 0].astype(int),
            touch[:, 2:5],
            touch[:, 5:8] if rolling else None,
        ),
        wall_planes(packing),
        (
            balance.Material(
                balance.effective_modulus((moduli[0],) * 2, (ratios[0],) * 2), constants.friction
            ),
            balance.Material(balance.effective_modulus(moduli, ratios), constants.wall_friction),
        ),
        run.acceleration * np.sin(phase),
        run.bed.gravity * np.array(run.bed.gravity_direction),
        stride * run.time_step,
    )
    # CLOSURE_LIMIT of this is the smallest error that is asked of C_e anywhere
    smallest = cycles.dissipated_energy(floor, run.amplitude, run.frequency)
    least = float(smallest) / CLOSURE_LIMIT * window * packing.area
    return {
        **asdict(found),
        "closure": found.residual / max(abs(found.work), found.dissipated, least),
        "cycles": window,
        "frames": len(motion),
    }


def _stride(steps: int, longest: float) -> int:
    """The longest stride of so many steps or fewer that divides a cycle of ``steps``."""
    return max(k for k in range(1, max(1, int(longest)) + 1) if steps % k == 0)


def _columns(compute: str, ids: tuple[int, int], rolling: bool) -> str:
    """Ids, force and, for rolling friction, torque in the output of ``pair/gran/local``."""
    values = (*ids, 4, 5, 6, 7, 8, 9) if rolling else (*ids, 4, 5, 6)
    return " ".join(f"c_{compute}[{k}]" for k in values)
