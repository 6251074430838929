"""One scenario: a patch, its damping as a function of its own motion, one level of the sound.

The Γ at which C_e(r, f, Γ) is read is either stated or the patch's own: the one that reproduces
itself (`linearisation`). Whether the answer is within the simulated range is carried along.
"""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Complexes, Flags
from pidpanel.response.dampers import (
    PatchMotion,
    acceleration_slope,
    attach_dampers,
    diagonal_response,
    diagonal_slope,
)
from pidpanel.response.linearisation import DampingOfMotion, find_motions, sine_acceleration_g
from pidpanel.response.modal import BarePanel
from pidpanel.response.model import ModalBasis, Patches, Response


@dataclass(frozen=True)
class ScenarioResponse:
    """A response and the damping it was computed with.

    Parameters
    ----------
    response
        PSDs of points and patch.
    acceleration_g
        Γ at which the damping was read; NaN for the bare panel and for a law without Γ.
    patch_acceleration_g
        Γ of the sine with the rms acceleration that the patch ends up with.
    equivalent_damping, apparent_mass
        (nf,) C_e [N s/m³] and m_a [kg/m²] of the patch.
    inside
        (nf,) whether the damping is within the simulated range.
    fixed_points
        Number of Γ that reproduce themselves (1 unless C_e falls steeply with Γ).
    """

    response: Response
    acceleration_g: float
    patch_acceleration_g: float
    equivalent_damping: Array
    apparent_mass: Array
    inside: Flags
    fixed_points: int


class Solver:
    """Panel with one patch and its full modal damping matrix.

    Parameters
    ----------
    bare
        The bare panel on the lines of the result.
    motion
        Motion of its patch on fewer lines, for the search of its Γ.
    """

    def __init__(self, bare: BarePanel, motion: PatchMotion) -> None:
        self.frequency = bare.frequency
        self.motion = motion
        self._bare = bare

    def bare(self) -> Response:
        """Return the response without a damper."""
        return Response(self.frequency, self._bare.point_psd)

    def response(self, equivalent_damping: Array, apparent_mass: Array) -> Response:
        """Return the response with C_e (nf,) and m_a (nf,) on the patch."""
        return attach_dampers(self._bare, equivalent_damping[None], apparent_mass[None])

    def slope(self, equivalent_damping: Array, apparent_mass: Array) -> Complexes:
        """Return how the PSDs follow the damper, t (nf, n_points) of `acceleration_slope`."""
        return acceleration_slope(self._bare, equivalent_damping, apparent_mass)


class DiagonalSolver:
    """The paper's form (Eq. 9-15): modes uncoupled by the damper.

    Parameters are those of `dampers.diagonal_response`, of one patch, and `motion` as of `Solver`.
    """

    def __init__(
        self,
        frequency: Array,
        basis: ModalBasis,
        patch: Patches,
        motion_at_points: Array,
        pressure_psd: Array,
        modal_force: Callable[[Array], Array | Complexes],
        motion: PatchMotion,
    ) -> None:
        self.frequency = frequency
        self.motion = motion
        self._panel = (frequency, basis, patch, motion_at_points, pressure_psd, modal_force)

    def bare(self) -> Response:
        """Return the response without a damper."""
        zero = np.zeros(self.frequency.shape)
        return self.response(zero, zero)

    def response(self, equivalent_damping: Array, apparent_mass: Array) -> Response:
        """Return the response with C_e (nf,) and m_a (nf,) on the patch."""
        return diagonal_response(*self._panel, equivalent_damping[None], apparent_mass[None])

    def slope(self, equivalent_damping: Array, apparent_mass: Array) -> Complexes:
        """Return how the PSDs follow the damper, t (nf, n_points) of `acceleration_slope`."""
        return diagonal_slope(*self._panel, equivalent_damping, apparent_mass)


def solve_bare(solver: Solver | DiagonalSolver, pressure_factor: float) -> ScenarioResponse:
    """Return the response without any damper."""
    zero, none = np.zeros(solver.frequency.shape), np.zeros(solver.motion.frequency.shape)
    own = sine_acceleration_g(np.sqrt(pressure_factor) * solver.motion.acceleration_rms(none, none))
    return ScenarioResponse(
        response=solver.bare().under(pressure_factor),
        acceleration_g=np.nan,
        patch_acceleration_g=own,
        equivalent_damping=zero,
        apparent_mass=zero,
        inside=np.ones(zero.shape, dtype=np.bool_),
        fixed_points=0,
    )


def solve_scenario(
    solver: Solver | DiagonalSolver,
    damping: DampingOfMotion,
    pressure_factor: float,
    *,
    depends_on_acceleration: bool = True,
    stated_acceleration_g: float | None = None,
) -> ScenarioResponse:
    """Return the response with a damper whose C_e and m_a are read at one Γ.

    Parameters
    ----------
    solver
        The panel with its patch.
    damping
        C_e and m_a of the filled patch as a function of frequency and Γ.
    pressure_factor
        S_p over that of the solver.
    depends_on_acceleration
        Whether `damping` depends on Γ at all.
    stated_acceleration_g
        Γ to read the damping at; left out, the Γ of the patch's own motion is found.

    Raises
    ------
    UnstableDamping
        Where C_e is negative, as the paper's law as printed.
    LinearisationError
        Where motion and damping agree nowhere.
    """

    def patch_rms(value: Array, mass: Array) -> float:
        return float(np.sqrt(pressure_factor)) * solver.motion.acceleration_rms(value, mass)

    lines = solver.motion.frequency
    gamma, count = np.nan, 1
    if stated_acceleration_g is not None:
        gamma = stated_acceleration_g
    elif depends_on_acceleration:
        # a passive damper can move the patch more than no damper only where its mass tunes a
        # resonance to a peak of the sound, and never to a hundredth
        zero = np.zeros(lines.shape)
        bare = sine_acceleration_g(patch_rms(zero, zero))
        search = find_motions(lines, damping, patch_rms, (bare / 100, 3 * bare), scan_count=13)
        gamma, count = search.governing.gamma, len(search.fixed_points)
    own = sine_acceleration_g(patch_rms(*damping(lines, gamma)[:2]))
    value, mass, inside = damping(solver.frequency, gamma)
    response = solver.response(value, mass).under(pressure_factor)
    return ScenarioResponse(response, gamma, own, value, mass, np.asarray(inside), count)
