"""LIGGGHTS as a library: the spheres of some cells as arrays that are changed from step to step.

The only module that knows the C interface. An error of LIGGGHTS ends the process that loaded it:
this runs in a process of its own (`process`).
"""

from __future__ import annotations

import os
from ctypes import CDLL, POINTER, RTLD_GLOBAL, byref, c_char_p, c_double, c_int, c_void_p, cast
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.coupon.liggghts.deck import without_comments
from pidpanel.coupon.liggghts.failures import ParticlesLost, SolverMissing
from pidpanel.coupon.liggghts.process import LONE_RANK

MPI, LIBRARY = "libmpi.so.40", "libliggghts.so.3"
STEP = b"run 1 pre no post no"
"""One step: half a kick, drift, contact forces, half a kick; nothing is set up or printed."""


def load_library() -> CDLL:
    """Load the shared library of LIGGGHTS.

    Raises
    ------
    SolverMissing
        With the package that brings it.
    """
    os.environ.update(LONE_RANK)
    try:
        CDLL(MPI, RTLD_GLOBAL)
        found = CDLL(LIBRARY, RTLD_GLOBAL)
    except OSError as error:
        raise SolverMissing(f"{error}; on Debian: apt-get install liggghts") from None
    found.lammps_extract_atom.restype = c_void_p
    found.lammps_get_natoms.restype = c_int
    return found


def commands(text: str) -> list[str]:
    r"""Commands of a deck as the library takes them, one by one.

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
        Of `load_library`.
    deck
        ``templates/coupled.in.j2`` with its values, or text that ends likewise in ``run 0``.
    group
        (n,) the station of each sphere, spheres in the order of the data file and of the stations.
    weight
        (stations,) gravity on the spheres of each station along z [N], which the deck applies.

    Attributes
    ----------
    velocity, force
        (n, 3) of the spheres, of which the force holds gravity [m/s], [N].

    Raises
    ------
    ParticlesLost
        If LIGGGHTS holds other spheres than ``group``, or in another order.
    """

    velocity: Array
    force: Array

    def __init__(self, library: CDLL, deck: str, group: Index, weight: Array) -> None:
        self._library = library
        words = (b"liggghts", b"-screen", b"/dev/stdout", b"-log", b"none")
        arguments = (c_char_p * len(words))(*words)
        self._handle = c_void_p()
        library.lammps_open_no_mpi(len(words), arguments, byref(self._handle))
        for line in commands(deck):
            library.lammps_command(self._handle, line.encode())
        count = library.lammps_get_natoms(self._handle)
        if count != len(group):
            raise ParticlesLost(f"LIGGGHTS holds {count} spheres, not {len(group)}")
        identity = cast(library.lammps_extract_atom(self._handle, b"id"), POINTER(c_int))
        # sums over a station are sums over a slice
        if np.any(np.diff(group) < 0) or identity[:count] != list(range(1, count + 1)):
            raise ParticlesLost("the spheres are not in the order of their stations")
        self._station = group
        self._weight = weight
        self._start = np.searchsorted(group, np.arange(len(weight)))
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
        """Write the spheres and their contacts to a file; the last that is asked of them.

        A deck that begins with this file, and `go_on` with the forces of now, go on from here:
        LIGGGHTS computes the forces of a restart from other velocities than those of a step.
        """
        self._library.lammps_command(self._handle, f"write_restart {path}".encode())

    def forces(self) -> Array:
        """Return forces and torques on the spheres, (n, 6) [N], [N m]."""
        return np.hstack([self.force, self._torque])

    def go_on(self, forces: Array) -> None:
        """Set forces and torques to what `forces` said when the restart was written."""
        self.force[:], self._torque[:] = forces[:, :3], forces[:, 3:]

    def wall_force(self) -> Array:
        """Return the force of the walls on the spheres of each station along z, (stations,) [N].

        The sum over all contacts: those between spheres cancel.
        """
        total: Array = np.add.reduceat(self._force_z, self._start) - self._weight
        return total

    def step(self, kick: Array) -> None:
        """Give the spheres of each station a velocity along z, (stations,) [m/s]; go one step."""
        self._velocity_z += kick[self._station]
        self._library.lammps_command(self._handle, STEP)
        if self._addresses() != self._address:
            self._attach()
