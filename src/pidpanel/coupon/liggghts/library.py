"""LIGGGHTS as a library: the spheres of some cells as arrays that are changed between steps.

The only module that knows the C interface. An error of LIGGGHTS ends the process that loaded it:
this runs in a process of its own (`process`).
"""

import os
from ctypes import CDLL, POINTER, RTLD_GLOBAL, byref, c_char_p, c_double, c_int, c_void_p, cast
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.coupon.liggghts.deck import without_comments
from pidpanel.coupon.liggghts.failures import ParticlesLost, SolverMissing
from pidpanel.coupon.liggghts.process import LONE_RANK

MPI, LIBRARY = "libmpi.so.40", "libliggghts.so.3"


def load_library() -> CDLL:
    """Load the shared library of LIGGGHTS.

    Raises
    ------
    SolverMissing
        If the library is not installed, with its package.
    """
    os.environ.update(LONE_RANK)
    try:
        CDLL(MPI, RTLD_GLOBAL)
        library = CDLL(LIBRARY, RTLD_GLOBAL)
    except OSError as error:
        raise SolverMissing(f"{error}; on Debian: apt-get install liggghts") from None
    library.lammps_extract_atom.restype = c_void_p
    library.lammps_get_natoms.restype = c_int
    return library


def commands(text: str) -> list[str]:
    r"""Return the commands of a deck as the library takes them, one by one.

    Examples
    --------
    >>> commands("# walls\nfix a all &\n    mesh # one\nrun 0\n")
    ['fix a all mesh', 'run 0']
    """
    return without_comments(text).replace(" &\n", " ").splitlines()


class Spheres:
    """The spheres of some cells in LIGGGHTS.

    Parameters
    ----------
    library
        Library returned by `load_library`.
    deck
        ``templates/coupled.in.j2`` with its values, or text that ends likewise in ``run 0``.
    cell, mass
        (n,) the cell and the mass [kg] of each sphere, in the order of the data file and of the
        cells.
    gravity
        Gravity along z, the same as in the deck [m/s²].
    time_step
        Time step, the same as in the deck [s].

    Raises
    ------
    ParticlesLost
        If LIGGGHTS has other spheres than ``cell``, or in another order.
    """

    # (n, 3) of the spheres; the force includes gravity [m/s], [N]
    velocity: Array
    force: Array

    def __init__(
        self, library: CDLL, deck: str, cell: Index, mass: Array, gravity: float, time_step: float
    ) -> None:
        self._library = library
        words = (b"liggghts", b"-screen", b"/dev/stdout", b"-log", b"none")
        arguments = (c_char_p * len(words))(*words)
        self._handle = c_void_p()
        library.lammps_open_no_mpi(len(words), arguments, byref(self._handle))
        for line in commands(deck):
            library.lammps_command(self._handle, line.encode())
        count = library.lammps_get_natoms(self._handle)
        if count != len(cell):
            raise ParticlesLost(f"LIGGGHTS holds {count} spheres, not {len(cell)}")
        identity = cast(library.lammps_extract_atom(self._handle, b"id"), POINTER(c_int))
        # sums over a cell are sums over a slice
        if np.any(np.diff(cell) < 0) or identity[:count] != list(range(1, count + 1)):
            raise ParticlesLost("the spheres are not in the order of their cells")
        self._cell, self._mass, self._time_step = cell, mass, time_step
        self._start = np.flatnonzero(np.diff(cell, prepend=-1))
        self._weight = gravity * np.add.reduceat(mass, self._start)
        self._count = count
        self._attach()

    def _attach(self) -> None:
        """Find the arrays of LIGGGHTS, which move when they grow."""
        self._address = self._addresses()
        self.velocity, self.force, self._torque = (
            np.ctypeslib.as_array(cast(address, POINTER(c_double)), (self._count, 3))
            for address in self._address
        )
        self._velocity_z, self._force_z = self.velocity[:, 2], self.force[:, 2]

    def _addresses(self) -> tuple[int, ...]:
        def first_row(name: bytes) -> int:
            rows = cast(self._library.lammps_extract_atom(self._handle, name), POINTER(c_void_p))
            return int(rows[0] or 0)

        return first_row(b"v"), first_row(b"f"), first_row(b"torque")

    def write_restart(self, path: Path) -> None:
        """Write spheres and contacts to a file; the last call of a run.

        A deck that reads this file, followed by `restore_forces`, resumes the run: LIGGGHTS
        computes the forces of a restart from other velocities than those of a step.
        """
        self._library.lammps_command(self._handle, f"write_restart {path}".encode())

    def forces(self) -> Array:
        """Return forces and torques on the spheres, (n, 6) [N], [N m]."""
        return np.hstack([self.force, self._torque])

    def restore_forces(self, forces: Array) -> None:
        """Set forces and torques to what `forces` returned when the restart was written."""
        self.force[:], self._torque[:] = forces[:, :3], forces[:, 3:]

    def wall_force(self) -> Array:
        """Return the force of the walls on the spheres of each cell along z, (cells,) [N].

        The sum over all contacts, in which those between spheres cancel.
        """
        return np.add.reduceat(self._force_z, self._start) - self._weight

    def advance(self, kick: Array, substeps: int) -> Array:
        """Add a velocity along z, (cells,) [m/s], to the spheres of each cell and go some steps.

        Returns
        -------
        (cells,) impulse of the walls along z [N s]: the momentum gained, without that of gravity.
        """
        self._velocity_z += kick[self._cell]
        before = self._momentum()
        command = f"run {substeps} pre no post no"
        self._library.lammps_command(self._handle, command.encode())
        if self._addresses() != self._address:
            self._attach()
        return self._momentum() - before - self._weight * (substeps * self._time_step)

    def _momentum(self) -> Array:
        return np.add.reduceat(self._mass * self._velocity_z, self._start)
