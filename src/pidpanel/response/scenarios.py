"""One scenario: a patch, its damping as a function of its own motion, one sound level.

The level at which C_e(r, f, Γ) is read is either stated or the patch's own: the Γ that
reproduces itself (`linearisation`). Whether the answer rests on run points is carried along.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from pidpanel.response.linearisation import find_levels, sine_level
from pidpanel.response.modal import (
    BarePanel,
    attach_dampers,
    diagonal_response,
)
from pidpanel.response.model import Floats, ModalBasis, Patches, Response

DampingOfLevel = Callable[[Floats, float], tuple[Floats, Floats, NDArray[np.bool_]]]
"""(frequency (nf,) [Hz], Γ) → C_e (nf,) [N s/m³], m_a (nf,) [kg/m²], on run points (nf,)."""


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
        (nf,) whether the damping rests on run points.
    levels
        Number of Γ that reproduce themselves (1 unless C_e falls steeply with Γ).
    """

    response: Response
    acceleration_g: float
    patch_acceleration_g: float
    equivalent_damping: Floats
    apparent_mass: Floats
    inside: NDArray[np.bool_]
    levels: int


def at_level(bare: BarePanel, pressure_factor: float) -> BarePanel:
    """Return the same panel under S_p times ``pressure_factor`` at every frequency."""
    return replace(bare, displacement_psd=pressure_factor * bare.displacement_psd)


class Solver:
    """Panel with one patch and its full modal damping matrix.

    Parameters
    ----------
    fine
        The bare panel on the lines of the result.
    coarse
        The same on fewer lines and with fewer eigenvalues of D, for the search of a level.
    """

    def __init__(self, fine: BarePanel, coarse: BarePanel) -> None:
        self.frequency = fine.frequency
        self.coarse_frequency = coarse.frequency
        self._fine = fine
        self._coarse = coarse

    def response(
        self, equivalent_damping: Floats, apparent_mass: Floats, pressure_factor: float
    ) -> Response:
        """Return the response with C_e (nf,) and m_a (nf,) on the patch."""
        bare = at_level(self._fine, pressure_factor)
        return attach_dampers(bare, equivalent_damping[None], apparent_mass[None])

    def patch_rms(
        self, equivalent_damping: Floats, apparent_mass: Floats, pressure_factor: float
    ) -> float:
        """Return the rms acceleration of the patch [m/s²], on the coarse lines."""
        bare = at_level(self._coarse, pressure_factor)
        response = attach_dampers(bare, equivalent_damping[None], apparent_mass[None])
        return float(response.patch_acceleration_rms[0])


class DiagonalSolver:
    """The paper's form (Eq. 9-15): modes uncoupled by the damper.

    Parameters are those of `modal.diagonal_response`; one patch.
    """

    def __init__(
        self,
        frequency: Floats,
        basis: ModalBasis,
        patch: Patches,
        shape_at_points: Floats,
        pressure_psd: Floats,
        modal_force: Callable[[Floats], Floats],
    ) -> None:
        self.frequency = self.coarse_frequency = frequency
        self._arguments = (frequency, basis, patch, shape_at_points)
        self._pressure_psd = pressure_psd
        self._modal_force = modal_force

    def response(
        self,
        equivalent_damping: Floats,
        apparent_mass: Floats,
        pressure_factor: float,
    ) -> Response:
        """Return the response with C_e (nf,) and m_a (nf,) on the patch."""
        return diagonal_response(
            *self._arguments,
            pressure_factor * self._pressure_psd,
            self._modal_force,
            equivalent_damping[None],
            apparent_mass[None],
        )

    def patch_rms(
        self, equivalent_damping: Floats, apparent_mass: Floats, pressure_factor: float
    ) -> float:
        """Return the rms acceleration of the patch [m/s²]."""
        response = self.response(equivalent_damping, apparent_mass, pressure_factor)
        return float(response.patch_acceleration_rms[0])


def solve_bare(solver: Solver | DiagonalSolver, pressure_factor: float) -> ScenarioResponse:
    """Return the response without any damper."""
    zero = np.zeros(solver.frequency.shape)
    response = solver.response(zero, zero, pressure_factor)
    inside = np.ones(zero.shape, dtype=np.bool_)
    own = sine_level(float(response.patch_acceleration_rms[0]))
    return ScenarioResponse(response, np.nan, own, zero, zero, inside, 0)


def solve_scenario(
    solver: Solver | DiagonalSolver,
    damping: DampingOfLevel,
    pressure_factor: float,
    *,
    depends_on_level: bool = True,
    stated_level: float | None = None,
    damper_mass: bool = True,
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
    depends_on_level
        Whether `damping` depends on Γ at all.
    stated_level
        Γ to read the damping at; left out, the Γ of the patch's own motion is found.
    damper_mass
        Whether m_a acts; without it the damper is a dashpot.

    Raises
    ------
    UnstableDamping
        Where C_e is negative, as the paper's law as printed.
    LinearisationError
        Where motion and damping agree nowhere.
    """

    def read(frequency: Floats, level: float) -> tuple[Floats, Floats, NDArray[np.bool_]]:
        value, mass, inside = damping(frequency, level)
        return value, mass if damper_mass else np.zeros_like(mass), inside

    def patch_rms(value: Floats, mass: Floats) -> float:
        return solver.patch_rms(value, mass, pressure_factor)

    level, count = np.nan, 1
    if stated_level is not None:
        level = stated_level
    elif depends_on_level:
        # a passive damper can move the patch more than no damper only where its mass tunes a
        # resonance to a peak of the sound, and never to a hundredth
        zero = np.zeros(solver.coarse_frequency.shape)
        bare = sine_level(patch_rms(zero, zero))
        search = find_levels(
            solver.coarse_frequency, read, patch_rms, (bare / 100, 3 * bare), scan_count=13
        )
        level, count = search.governing.gamma, len(search.fixed_points)
    value, mass, inside = read(solver.frequency, level)
    response = solver.response(value, mass, pressure_factor)
    own = sine_level(float(response.patch_acceleration_rms[0]))
    return ScenarioResponse(response, level, own, value, mass, np.asarray(inside), count)
