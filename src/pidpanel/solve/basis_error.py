"""Error of a response due to the basis, and a better basis.

At a few lines of every scenario the same panel is solved on all elements (`elements`), under the
same excitation; the error of the basis is the largest difference of the PSD of a point, relative to
that of all elements. The check is of the structure alone: in vacuum, with the dampers' C_e and
m_a of the scenario. Where the error is above what is allowed, what the basis left out joins it.
"""

import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from typing import TypeVar

import numpy as np
import scipy.linalg as la
import scipy.sparse as sp

from pidpanel.arrays import Array, Complexes
from pidpanel.damping_ratio import DampingRatio
from pidpanel.panel.basis import PanelBasis, values_of, with_condensed_face
from pidpanel.panel.matrices import StoredPlate
from pidpanel.panel.shapes import MODES_BEYOND, Shapes
from pidpanel.progress import map_in_forks, with_progress
from pidpanel.solve.elements import ElementMotion, Elements
from pidpanel.solve.excitation import Matrices
from pidpanel.solve.model import ModalBasis

ALLOWED = 5e-3  # largest error of a PSD that is left to the basis

ATTEMPTS = 4  # bases that are tried: each further one has the shapes that the one before lacked

# Error at the lines tried above which the basis is refined: between them it may be larger.
REFINED_ABOVE = 4e-3

# Share of `REFINED_ABOVE` that is left where the basis is refined, at the lines tried.
REMAINDER = 0.1

LINES = (2, 12)  # fewest and most lines of a scenario

# Coordinates times columns of all scenarios that set the number of lines: on a panel of 50 000
# coordinates with three points and 22 scenarios the check has 3 lines each.
WORK = 1.2e7


T = TypeVar("T")

# (frequency [Hz], basis whose face moves in n shapes) → G (n, n) [m⁴]
ForceAt = Callable[[float, PanelBasis], Matrices]

# (frequency [Hz], s (n_scenarios, n_patches), motions of each scenario) → largest relative error of
# the PSD of a point (n_scenarios,) [1].
ErrorsAt = Callable[[float, Complexes, Sequence[ElementMotion]], Array]


@dataclass(frozen=True)
class BasisCheck:
    """Errors of the basis in every scenario."""

    error: Array  # (n_scenarios, nf) largest relative error of the PSD of a point at a line [1]
    # (n_free, k) what the basis lacks where the error is above `REFINED_ABOVE`
    missing_shapes: Array

    @property
    def largest(self) -> Array:
        """(n_scenarios,) [1]."""
        return self.error.max(axis=1)


def sufficient_basis(
    further_shapes: Array, check: Callable[[Array, int], tuple[T, Sequence[BasisCheck]]]
) -> tuple[T, float]:
    """Return what belongs to a basis that is good in all checks, and its largest error [1].

    After `ATTEMPTS` bases the last is used as it is, with its error.

    Parameters
    ----------
    further_shapes
        (n_free, k) what joins the basis of the panel stage from the first.
    check
        Function of further shapes and the number of the attempt from 0.
    """
    for attempt in range(ATTEMPTS):
        result, checks = check(further_shapes, attempt)
        error = max(float(part.error.max(initial=0.0)) for part in checks)
        missing = np.hstack([part.missing_shapes for part in checks])
        if not missing.shape[1] or attempt == ATTEMPTS - 1:
            break
        print(f"the basis misses up to {error:.1%} of a PSD; it is widened", file=sys.stderr)
        further_shapes = np.hstack([further_shapes, missing])
    if error > ALLOWED:
        message = f"the basis misses up to {error:.1%} of a PSD, more than {ALLOWED:.1%}"
        print(message, file=sys.stderr)
    return result, error


def lines_to_try(
    frequency_range: tuple[float, float], coordinates: int, columns: int, attempt: int = 0
) -> Array:
    """Return the lines [Hz] at which all elements are solved, denser towards the highest.

    Parameters
    ----------
    frequency_range
        Frequency range of the response [Hz].
    attempt
        Number of the basis from 0. Each has lines of its own, since a basis is right at the lines
        at which it was refined.
    """
    count = int(np.clip(WORK // max(1, coordinates * columns), *LINES))
    low, high = frequency_range
    offset = (0.5 + attempt * (np.sqrt(5) - 1) / 2) % 1  # the golden section keeps them apart
    share = np.sqrt((np.arange(count) + offset) / count)
    return low + (high - low) * share


def modal_basis(basis: PanelBasis, damping_ratio: DampingRatio, highest: float) -> ModalBasis:
    """Return the shapes of the bare panel with damping, for responses up to ``highest`` [Hz].

    ζ is that of the panel in modes, and ζ(f_c) f/f_c in residual vectors, which have none of their
    own. With a damping proportional to the stiffness above f_c the answer does not depend on how
    the shapes above are chosen.
    """
    cutoff = damping_cutoff(basis, highest)
    ratio = damping_ratio.ratio_at(cutoff) * (basis.natural_frequency / cutoff)
    modes = ~basis.is_residual
    ratio[modes] = damping_ratio.of_modes(basis.natural_frequency[modes])
    return ModalBasis(basis.natural_frequency, basis.modal_mass, ratio)


def damping_cutoff(basis: PanelBasis, highest: float) -> float:
    """Return f_c [Hz], above which damping is proportional to the stiffness.

    All modes of the basis are below, and it is at least `MODES_BEYOND` times the highest frequency.
    """
    modes = basis.natural_frequency[~basis.is_residual]
    return max(MODES_BEYOND * highest, float(modes.max(initial=0.0)))


def check_basis(
    basis: PanelBasis,
    plate: StoredPlate,
    shapes: Array,
    errors: ErrorsAt,
    damping_ratio: DampingRatio,
    highest: float,
    frequency: Array,
    scenarios: Complexes,
) -> BasisCheck:
    """Compare the basis with all elements.

    Parameters
    ----------
    shapes
        (n_free, n) shapes of the basis.
    errors
        Function for the errors of the PSDs under the excitation of the study.
    damping_ratio, highest
        Same as in `modal_basis`.
    frequency
        (nf,) [Hz].
    scenarios
        (n_scenarios, n_patches, nf) s of the dampers [N/m³]; 0 where a patch has none.
    """
    cutoff = damping_cutoff(basis, highest)
    overlap, modal = list(plate.patch_overlap.values()), modal_basis(basis, damping_ratio, highest)
    points, ratio = plate.at_points, damping_ratio.ratio_at(cutoff)
    elements = Elements(plate, overlap, shapes, modal, basis.is_residual, ratio, cutoff, points)
    elements.prepare()

    def at_line(line: int) -> tuple[Array, list[Array]]:
        """Return errors (n_scenarios,), and what the basis lacks."""
        f, stiffness = float(frequency[line]), scenarios[:, :, line]
        motions = elements.motions(f, stiffness)
        error = errors(f, stiffness, motions)
        missing_shapes = []
        for missed in np.flatnonzero(error > REFINED_ABOVE):
            missing = motions[missed].remainder
            energy = np.einsum("ki,ki->i", missing.conj(), plate.stiffness @ missing).real
            moved = energy > 0  # not of a point on a support
            missing = missing[:, moved] * (error[missed] / REFINED_ABOVE / np.sqrt(energy[moved]))
            missing_shapes += [np.real(missing), np.imag(missing)]
        return error, missing_shapes

    lines = range(len(frequency))
    error = np.zeros((len(scenarios), len(frequency)))
    missing_shapes: list[Array] = [np.zeros((plate.shapes.shape[0], 0))]
    for line, (error_there, missing_there) in zip(
        with_progress(lines, "lines of the check against all elements"),
        map_in_forks(at_line, lines),
        strict=True,
    ):
        error[:, line] = error_there
        missing_shapes += missing_there
    return BasisCheck(error, principal(plate.stiffness, np.hstack(missing_shapes)))


def principal(stiffness: sp.csr_array, columns: Array, remainder: float = REMAINDER) -> Array:
    """Return the fewest shapes that leave at most ``remainder`` of any column.

    Scenarios that differ in fill or level, and lines side by side, miss nearly the same.
    """
    square, V = la.eigh(columns.T @ (stiffness @ columns))
    square, V = np.maximum(square[::-1], 0.0), V[:, ::-1]
    left = np.sum(V**2 * square, axis=1)[:, None] - np.cumsum(V**2 * square, axis=1)
    too_few = np.count_nonzero(np.any(left > remainder**2, axis=0))  # none leaves more than fewer
    return columns @ V[:, : too_few + 1]


def pressure_errors(
    basis: PanelBasis,
    plate: StoredPlate,
    force_of_basis: Callable[[Array], Matrices],
    force_at: ForceAt,
) -> ErrorsAt:
    """Return the errors under random pressures on the face.

    Parameters
    ----------
    force_of_basis
        G of the field of the study on the shapes of the basis over frequency [m⁴].
    force_at
        The same at a frequency [Hz] on given shapes.
    """

    def errors(frequency: float, _: Complexes, motions: Sequence[ElementMotion]) -> Array:
        # w = xᵀ F with x = a + ib: E|w|² = xᵀ G x*, and G is Hermitian
        answer = np.stack([motion.of_basis for motion in motions])  # (n_scenarios, n, n_points)
        (force,) = force_of_basis(np.array([frequency]))
        in_basis = np.sum(answer * (force @ answer.conj()), axis=1).real
        wholes = [motion.whole for motion in motions]
        columns = np.hstack([part for whole in wholes for part in (whole.real, whole.imag)])
        moved = replace(
            basis,
            quadrature_position=plate.quadrature_position,
            quadrature_weight=plate.quadrature_weight,
            shape_at_quadrature=plate.at_quadrature @ columns,
            shape_at_vertices=plate.at_vertices @ columns,
        )
        if np.isfinite(basis.quadrature_wavenumber):
            moved = with_condensed_face(moved, basis.quadrature_wavenumber)
        force = force_at(frequency, moved)
        blocks = np.arange(columns.shape[1]).reshape(len(motions), 2, -1)
        real, imag = blocks[:, 0], blocks[:, 1]
        cross = force[imag, real] - force[real, imag]
        psd = (force[real, real] + force[imag, imag] + 1j * cross).real  # (n_scenarios, n_points)
        # a point on a support does not move
        ratio = np.divide(in_basis, psd, out=np.ones_like(psd), where=psd > 0)
        return np.asarray(np.abs(ratio - 1).max(axis=1, initial=0.0))

    return errors


def basis_shapes(basis: PanelBasis, plate: StoredPlate, further: Array) -> Shapes:
    """Return the shapes of the panel stage's basis with what it left out (n_free, k)."""
    frequency = basis.natural_frequency
    vectors = plate.shapes.astype(np.float64)
    shapes = Shapes(frequency[~basis.is_residual], frequency[basis.is_residual], vectors)
    return shapes.joined_by(plate, further) if further.shape[1] else shapes


def refined(basis: PanelBasis, plate: StoredPlate, shapes: Shapes) -> PanelBasis:
    """Return the basis of the panel stage with what it left out, see `basis_shapes`."""
    wider = replace(basis, **values_of(plate, shapes))
    return with_condensed_face(wider, basis.quadrature_wavenumber)
