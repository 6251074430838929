"""A panel on moving supports: absolute motion from relative motion and a translation.

All supports move along the normal by z. The panel moves by u = φᵀ q + z (a curved one by φᵀ q +
(n·d) z along its normals n, for a motion along d), q relative to them. With
L = φᵀ M 1 and d_p = ∫_p φ dA, dampers s_p = iω C_e − ω² m_a on patch p feel the absolute motion,

    (K − ω² M + iω C) q = ω² L z − Σ_p s_p (D_p q + d_p z).

The translation is one more shape of the basis, 1 everywhere: that of a table so heavy that no
panel moves it. A force M_table a moves the table by a, a force −L a the panel relative to it, so
that base motion is an excitation like any other, of one column.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.eigen import factors
from pidpanel.panel.matrices import StoredPlate
from pidpanel.solve.basis_error import basis_shapes, refined

# Mass of the table over that of the panel: dampers move it by 1e-8 of their own motion.
TABLE_MASS = 1e8


@dataclass(frozen=True)
class Translation:
    """Motion of a structure as a whole along a direction, as its shapes have it [1].

    The direction cosines (n,) at the points of the response, the vertices and the points of the
    quadrature; 1 everywhere on a panel.
    """

    points: Array | float = 1.0
    vertices: Array | float = 1.0
    quadrature: Array | float = 1.0
    direction: Array | None = None  # (3,) of a structure

    def with_points(self, vertices: Index) -> Translation:
        """Return it with some vertices as further points."""
        if isinstance(self.points, float):
            return self
        cosine = self.vertices
        further = np.full(len(vertices), cosine) if isinstance(cosine, float) else cosine[vertices]
        return replace(self, points=np.append(self.points, further))


UNIT = Translation()


@dataclass(frozen=True)
class Inertia:
    """Coupling of the shapes of a panel with a translation t.

    Attributes
    ----------
    participation
        (n,) L_i = φ_iᵀ M 1 [kg].
    mass
        1ᵀ M 1 of the panel with attached masses, supports included [kg].
    patch_integral
        (n_patches, n) ∫_p t φ_i dA [m²].
    patch_area
        (n_patches,) ∫_p t² dA [m²].
    face_integral
        (n,) ∫ t φ_i dA over the face [m²].
    """

    participation: Array
    mass: float
    patch_integral: Array
    patch_area: Array
    face_integral: Array
    translation: Translation = UNIT

    def effective_mass(self, modal_mass: Array) -> Array:
        """Return L_i²/m_i (n,) [kg], which sum to the mass over all modes."""
        return self.participation**2 / modal_mass


def inertia_of(
    basis: PanelBasis,
    plate: StoredPlate,
    vectors: Array,
    mass: float,
    translation: Translation = UNIT,
) -> Inertia:
    """Return the inertia of the shapes ``vectors`` (n_free, n) of a basis."""
    integrals = integrals_of_shapes(basis, plate, translation).T @ vectors.astype(np.float64)
    if plate.patch_translation is None:
        square = np.broadcast_to(np.square(translation.quadrature), len(plate.quadrature_weight))
        areas = _patch_weights(basis, plate)[:-1] @ square
    else:
        d = np.asarray(translation.direction)
        areas = np.einsum("i,pij,j->p", d, plate.patch_translation[:, -3:], d)
    mean = plate.inertia @ vectors, mass, integrals[:-1], areas, integrals[-1]
    return Inertia(*mean, translation)


def integrals_of_shapes(
    basis: PanelBasis, plate: StoredPlate, translation: Translation = UNIT
) -> Array:
    """Return ∫ t φ dA of all elements (n_free, n_patches + 1) over patches, then the face [m²]."""
    weights = _patch_weights(basis, plate) * translation.quadrature
    integrals = np.asarray(plate.at_quadrature.T @ weights.T)
    if plate.patch_translation is not None:
        integrals[:, :-1] = (plate.patch_translation[:, :-3] @ np.asarray(translation.direction)).T
    return integrals


def _patch_weights(basis: PanelBasis, plate: StoredPlate) -> Array:
    """Return weights (n_patches + 1, n_quadrature) over each patch, then the face [m²]."""
    face = plate.quadrature_weight
    if plate.patch_weight is not None:
        return np.vstack([plate.patch_weight.toarray(), face])
    per_cell = len(face) // len(basis.cells)  # cell by cell
    return np.array([*(np.repeat(cells, per_cell) * face for cells in basis.cell_in_patch), face])


def with_translation(basis: PanelBasis, inertia: Inertia) -> PanelBasis:
    """Return the basis with the translation as its last shape, which is no residual vector."""

    def joined(values: Array, last: Array | float) -> Array:
        column = np.broadcast_to(last, values.shape[:-1])[..., None]
        return np.concatenate([values, column], axis=-1)

    translation = inertia.translation
    area = np.sum(basis.quadrature_weight * np.square(translation.quadrature))
    return replace(
        basis,
        natural_frequency=joined(basis.natural_frequency, 0.0),
        modal_mass=joined(basis.modal_mass, TABLE_MASS * inertia.mass),
        is_residual=np.append(basis.is_residual, False),
        patch_overlap=_bordered(basis.patch_overlap, inertia.patch_integral, inertia.patch_area),
        face_overlap=_bordered(basis.face_overlap, inertia.face_integral, area),
        shape_at_points=joined(basis.shape_at_points, translation.points),
        shape_at_quadrature=joined(basis.shape_at_quadrature, translation.quadrature),
        shape_at_vertices=joined(basis.shape_at_vertices, translation.vertices),
        curvature_at_vertices=joined(basis.curvature_at_vertices, 0.0),
        shear_at_vertices=joined(basis.shear_at_vertices, 0.0),
        curvature_at_points=joined(basis.curvature_at_points, 0.0),
        shear_at_points=joined(basis.shear_at_points, 0.0),
        reactions=joined(basis.reactions, 0.0),
    )


def _bordered(matrix: Array, column: Array, corner: Array | float) -> Array:
    """Return symmetric matrices (…, n + 1, n + 1) with a last column (…, n) and its corner."""
    border = np.concatenate([column, np.asarray(corner)[..., None]], axis=-1)
    wide = np.concatenate([matrix, column[..., None, :]], axis=-2)
    return np.concatenate([wide, border[..., None]], axis=-1)


@dataclass(frozen=True)
class SupportedPanel:
    """The panel on its supports, in a basis with the static response to their acceleration."""

    basis: PanelBasis  # without the translation
    vectors: Array  # (n_free, n) its shapes
    inertia: Inertia


def supported_panel(
    basis: PanelBasis,
    plate: StoredPlate,
    further_shapes: Array,
    highest: float,
    mass: float,
    translation: Translation = UNIT,
) -> SupportedPanel:
    """Return the panel in its basis with further shapes, and K⁻¹ M 1.

    Parameters
    ----------
    further_shapes
        (n_free, k) shapes that the basis lacks.
    highest
        Highest frequency [Hz].
    mass
        Mass of the panel with attached masses [kg].
    """
    # a panel on hinges in a line has a singular K; the shift is of a hundredth of the frequency
    shift = (2 * np.pi * 0.01 * highest) ** 2
    static = factors(plate.stiffness + shift * plate.mass).solve(plate.inertia)
    shapes = basis_shapes(basis, plate, np.column_stack([further_shapes, static]))
    wider = refined(basis, plate, shapes)
    inertia = inertia_of(wider, plate, shapes.vectors, mass, translation)
    return SupportedPanel(wider, shapes.vectors, inertia)


@dataclass(frozen=True)
class BaseExcitation:
    """A random acceleration of the supports; implements `solve.excitation.Excitation`.

    Parameters
    ----------
    level
        PSD of the acceleration [(m/s²)²/Hz] over frequencies (nf,) [Hz].
    force
        (n + 1,) forces on the shapes and the translation per acceleration [kg].
    """

    level: Callable[[Array], Array]
    force: Array

    @classmethod
    def of_inertia(cls, level: Callable[[Array], Array], inertia: Inertia) -> BaseExcitation:
        """Return the excitation of a basis `with_translation`."""
        return cls(level, np.append(-inertia.participation, TABLE_MASS * inertia.mass))

    def spectrum(self, frequency: Array) -> Array:
        """Return S (nf,) [(m/s²)²/Hz]."""
        return self.level(frequency)

    def __call__(self, frequency: Array) -> Array:
        """Return G (1, n + 1, n + 1) [kg²]."""
        return np.outer(self.force, self.force)[None]

    def factors(self, frequency: Array) -> Array:
        """Return L (nf, n + 1, 1) [kg] with G = L Lᴴ."""
        return np.broadcast_to(self.force[:, None], (len(frequency), len(self.force), 1))


def observed_motions(basis: PanelBasis, inertia: Inertia) -> Array:
    """Return observed motions, as rows over the shapes with the translation.

    Returns
    -------
    (n_points + 1, m, n + 1) of each point the absolute and the relative deflection [1]; last the
    interface: M times the absolute motion [kg], then its integral over each patch [m²].
    """
    absolute, patches = basis.shape_at_points, inertia.patch_integral
    relative = absolute.copy()
    relative[:, -1] = 0.0
    points = np.zeros((len(absolute) + 1, max(2, 1 + len(patches)), absolute.shape[1]))
    points[:-1, 0], points[:-1, 1] = absolute, relative
    points[-1, 0] = np.append(inertia.participation, inertia.mass)
    points[-1, 1 : 1 + len(patches)] = np.column_stack([patches, inertia.patch_area])
    return points
