"""Inputs and results of the response: arrays with their checks."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.lines import root_mean_square


class ResponseError(ValueError):
    """Arrays or values from which no response can be computed."""


class UnstableDamping(ResponseError):
    """Equivalent damping that feeds energy to the panel: no steady response exists."""


@dataclass(frozen=True)
class ModalBasis:
    """Shapes of the bare panel that are orthogonal in mass and in stiffness.

    Residual vectors count as modes with their own (pseudo) natural frequency.

    Raises
    ------
    ResponseError
        If shapes disagree, a value is not finite and positive, or a frequency is negative.
    """

    # (n,) f_i [Hz], positive; 0 of a rigid body's mode, which has no damping of its own
    natural_frequency: Array
    modal_mass: Array  # (n,) m_i [kg], positive
    damping_ratio: Array  # ζ, one for all or (n,), positive [1]

    def __init__(
        self, natural_frequency: ArrayLike, modal_mass: ArrayLike, damping_ratio: ArrayLike
    ) -> None:
        frequency = np.array(natural_frequency, dtype=np.float64)
        if frequency.ndim != 1:
            raise ResponseError(f"natural_frequency has shape {frequency.shape}: (n,) is needed")
        for name, value in (
            ("natural_frequency", frequency),
            ("modal_mass", modal_mass),
            ("damping_ratio", damping_ratio),
        ):
            array = np.array(value, dtype=np.float64)
            if array.shape not in ((), frequency.shape) or (
                array.ndim == 0 and name == "modal_mass"
            ):
                raise ResponseError(f"{name} has shape {array.shape}: {frequency.shape} is needed")
            rigid = name == "natural_frequency"
            bad = ~(np.isfinite(array) & ((array >= 0) if rigid else (array > 0)))
            if np.any(bad):
                must = "must not be negative" if rigid else "must be finite and positive"
                raise ResponseError(f"{name} = {array[bad].flat[0]!r} {must}")
            object.__setattr__(self, name, np.broadcast_to(array, frequency.shape))

    @property
    def angular_frequency(self) -> Array:
        """(n,) ω_i = 2π f_i [rad/s]."""
        return 2 * np.pi * self.natural_frequency

    @property
    def damping(self) -> Array:
        """(n,) diagonal of C, 2 ζ_i m_i ω_i [N s/m]."""
        return 2 * self.damping_ratio * self.modal_mass * self.angular_frequency

    def dynamic_stiffness(self, frequency: Array) -> Complexes:
        """Return the diagonal m_i (ω_i² − ω² + 2iζ_i ω_i ω) of Z₀, (nf, n) [N/m]."""
        omega = 2 * np.pi * frequency[:, None]
        return self.modal_mass * (self.angular_frequency**2 - omega**2) + 1j * omega * self.damping


@dataclass(frozen=True)
class PatchCoordinates:
    """The motions of the shapes that some patches feel, D_p = E Δ_p Eᵀ."""

    columns: Array  # (n, r) E [m]
    # (n_patches, r, r) Δ_p [1], which sum to about one; of a patch alone the diagonal (1, r), ones
    weight: Array
    inverse: Array  # (r, n) of E: a motion cᵀq with c = E a is aᵀu, a = inverse c


class Patches:
    """Areas of the panel that carry dampers, each known by D_p = ∫_p φ φᵀ dA.

    Parameters
    ----------
    overlap
        (n_patches, n, n) D_p [m²], symmetric positive semidefinite.
    area
        (n_patches,) A_p [m²].

    Raises
    ------
    ResponseError
        If shapes disagree, D is not symmetric or has a negative eigenvalue.
    """

    def __init__(self, overlap: ArrayLike, area: ArrayLike) -> None:
        matrices = np.asarray(overlap, dtype=np.float64)
        if matrices.ndim != 3 or matrices.shape[1] != matrices.shape[2]:
            raise ResponseError(f"overlap has shape {matrices.shape}: (n_patches, n, n) is needed")
        self.area = _checked_area(area, matrices.shape[:1])
        for index, matrix in enumerate(matrices):
            largest = np.max(np.abs(matrix))
            if not np.isfinite(largest):
                raise ResponseError(f"overlap of patch {index} has values that are not finite")
            if np.max(np.abs(matrix - matrix.T)) > 1e-10 * largest:
                raise ResponseError(f"overlap of patch {index} is not symmetric")
        self.shapes = matrices.shape[1]  # number n
        self._coordinates: dict[float, PatchCoordinates] = {}
        self._factors = [_factor(index, matrix) for index, matrix in enumerate(matrices)]

    @classmethod
    def of_rows(cls, rows: ArrayLike, area: ArrayLike) -> "Patches":
        """Return patches from the rows of their quadrature, D_p = Σ row rowᵀ.

        Parameters
        ----------
        rows
            (n_patches, k, n) √weight times the shapes at k quadrature points of each patch [m].
        area
            (n_patches,) A_p [m²].

        Raises
        ------
        ResponseError
            If shapes disagree or a value is not finite.
        """
        parts = np.asarray(rows, dtype=np.float64)
        if not np.all(np.isfinite(parts)):
            raise ResponseError("rows have values that are not finite")
        area = _checked_area(area, parts.shape[:1])
        return cls._of_factors([_compressed(part.T) for part in parts], area, parts.shape[2])

    @classmethod
    def _of_factors(cls, factors: list[Array], area: Array, shapes: int) -> "Patches":
        patches = cls.__new__(cls)
        patches.area, patches.shapes = area, shapes
        patches._coordinates, patches._factors = {}, factors
        return patches

    @property
    def count(self) -> int:
        """Number of patches."""
        return int(self.area.size)

    @cached_property
    def overlap(self) -> Array:
        """(n_patches, n, n) D_p [m²]."""
        parts = [factor @ factor.T for factor in self._factors]
        return np.array(parts).reshape(self.count, self.shapes, self.shapes)

    @cached_property
    def diagonal(self) -> Array:
        """(n_patches, n) diagonals of D_p [m²]."""
        parts = [np.sum(factor**2, axis=1) for factor in self._factors]
        return np.array(parts).reshape(self.count, self.shapes)

    def subset(self, indices: Sequence[int]) -> "Patches":
        """Return some of the patches."""
        factors = [self._factors[index] for index in indices]
        return self._of_factors(factors, self.area[list(indices)], self.shapes)

    def factors(self, cutoff: float) -> list[Array]:
        """Return U_p (n, rank_p) [m] of each patch with D_p = U_p U_pᵀ.

        Eigenvalues of D_p, the squares of the columns of U_p, below `cutoff` times the largest
        are dropped.
        """
        factors = []
        for factor in self._factors:
            value = np.sum(factor**2, axis=0)
            factors.append(factor[:, value > cutoff * np.max(value, initial=0.0)])
        return factors

    def coordinates(self, cutoff: float) -> PatchCoordinates:
        """Return the motions that the patches together feel.

        Parameters
        ----------
        cutoff
            Share of the largest eigenvalue, of D of each patch and of all together, each patch in
            parts of its own largest, below which eigenvalues are dropped.
        """
        if cutoff not in self._coordinates:
            self._coordinates[cutoff] = _coordinates(self.factors(cutoff), cutoff, self.shapes)
        return self._coordinates[cutoff]


def _coordinates(factors: list[Array], cutoff: float, n: int) -> PatchCoordinates:
    if len(factors) == 1:
        (single,) = factors
        square = np.sum(single**2, axis=0)
        return PatchCoordinates(single, np.ones((1, single.shape[1])), (single / square).T)
    scaled = [u / np.sqrt(np.max(np.sum(u**2, axis=0), initial=1e-300)) for u in factors]
    stacked = np.concatenate([*scaled, np.zeros((n, 0))], axis=1)
    vector, value, _ = np.linalg.svd(stacked, full_matrices=False)
    large = value**2 > cutoff * np.max(value, initial=0.0) ** 2
    columns, inverse = vector[:, large] * value[large], (vector[:, large] / value[large]).T
    parts = [inverse @ u for u in factors]
    weight = np.array([u @ u.T for u in parts]).reshape(len(parts), *2 * inverse.shape[:1])
    return PatchCoordinates(columns, weight, inverse)


def _checked_area(area: ArrayLike, shape: tuple[int, ...]) -> Array:
    array = np.array(area, dtype=np.float64)
    if array.shape != shape:
        raise ResponseError(f"area has shape {array.shape}: {shape} is needed")
    bad = ~(np.isfinite(array) & (array > 0))
    if np.any(bad):
        raise ResponseError(f"area = {array[bad].flat[0]!r} m² must be finite and positive")
    return array


def _factor(index: int, overlap: Array) -> Array:
    """Return U (n, rank) of one D."""
    value, vector = np.linalg.eigh((overlap + overlap.T) / 2)
    if value[0] < -1e-10 * value[-1]:
        raise ResponseError(
            f"overlap of patch {index} has the eigenvalue {value[0]:g} m² "
            f"beside {value[-1]:g} m²: an integral of φ φᵀ has none below zero"
        )
    large = value > 1e-15 * value[-1]
    return vector[:, large] * np.sqrt(value[large])


def _compressed(factor: Array) -> Array:
    """Return U of D = factor factorᵀ with orthogonal columns."""
    left, value, _ = np.linalg.svd(factor, full_matrices=False)
    large = value**2 > 1e-15 * np.max(value, initial=0.0) ** 2
    return left[:, large] * value[large]


@dataclass(frozen=True)
class PanelResponse:
    """PSDs of the panel's motion at its points."""

    frequency: Array  # (nf,) [Hz]
    # (nf, n_points, m, m) one-sided cross-PSDs, E[a b*] per Hz, of the m motions at each point: the
    # deflection w [m] first, then further requested ones (see `bare_panels`)
    cross_psd: Complexes
    # (n_patches, nf, n_points) t of `dampers.attach_dampers`; None unless requested
    slope: Complexes | None = None

    def scaled(self, factor: float) -> "PanelResponse":
        """Return the response to ``factor`` times the PSD of the excitation."""
        slope = None if self.slope is None else factor * self.slope
        return replace(self, cross_psd=factor * self.cross_psd, slope=slope)

    @property
    def displacement_psd(self) -> Array:
        """(nf, n_points) S_w [m²/Hz]."""
        return np.ascontiguousarray(self.cross_psd[:, :, 0, 0].real, dtype=np.float64)

    @property
    def velocity_psd(self) -> Array:
        """(nf, n_points) S_v = ω² S_w [(m/s)²/Hz]."""
        return self.displacement_psd * (2 * np.pi * self.frequency[:, None]) ** 2

    @property
    def acceleration_psd(self) -> Array:
        """(nf, n_points) S_a = ω⁴ S_w [(m/s²)²/Hz]."""
        return self.displacement_psd * (2 * np.pi * self.frequency[:, None]) ** 4

    @property
    def acceleration_rms(self) -> Array:
        """(n_points,) rms acceleration over the range of frequency [m/s²]."""
        return root_mean_square(self.frequency, self.acceleration_psd)

    @property
    def velocity_rms(self) -> Array:
        """(n_points,) rms velocity over the range of frequency [m/s]."""
        return root_mean_square(self.frequency, self.velocity_psd)

    @property
    def displacement_rms(self) -> Array:
        """(n_points,) rms displacement over the range of frequency [m]."""
        return root_mean_square(self.frequency, self.displacement_psd)


def checked_array(name: str, value: ArrayLike, shape: tuple[int, ...]) -> Array:
    """Return an array of a shape; `ResponseError` with its name where it is not finite."""
    array = np.asarray(value, dtype=np.float64)
    if array.shape != shape:
        raise ResponseError(f"{name} has shape {array.shape}: {shape} is needed")
    if not np.all(np.isfinite(array)):
        raise ResponseError(f"{name} has values that are not finite")
    return array
