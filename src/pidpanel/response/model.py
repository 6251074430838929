"""What the response is computed from and what comes out: arrays with their checks."""

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes
from pidpanel.response.lines import root_mean_square


class ResponseError(ValueError):
    """Arrays or values from which no response can be computed."""


class UnstableDamping(ResponseError):
    """Equivalent damping that feeds energy to the panel: no steady response exists."""


@dataclass(frozen=True)
class ModalBasis:
    """Shapes of the bare panel that are orthogonal in mass and in stiffness.

    Residual vectors count as modes with their own (pseudo) natural frequency.

    Parameters
    ----------
    natural_frequency
        (n,) f_i [Hz], positive.
    modal_mass
        (n,) m_i [kg], positive.
    damping_ratio
        ζ, one for all or (n,), positive [1].

    Raises
    ------
    ResponseError
        Where shapes disagree or a value is not finite and positive.
    """

    natural_frequency: Array
    modal_mass: Array
    damping_ratio: Array

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
            bad = ~(np.isfinite(array) & (array > 0))
            if np.any(bad):
                raise ResponseError(f"{name} = {array[bad].flat[0]!r} must be finite and positive")
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
        stiffness: Complexes = (
            self.modal_mass * (self.angular_frequency**2 - omega**2) + 1j * omega * self.damping
        )
        return stiffness


@dataclass(frozen=True)
class Patches:
    """Areas of the panel that carry dampers.

    Parameters
    ----------
    overlap
        (n_patches, n, n) D_p = ∫_p φ φᵀ dA [m²], symmetric positive semidefinite.
    area
        (n_patches,) A_p [m²].

    Raises
    ------
    ResponseError
        Where shapes disagree, D is not symmetric or has a negative eigenvalue.
    """

    overlap: Array
    area: Array

    def __post_init__(self) -> None:
        overlap = np.array(self.overlap, dtype=np.float64)
        area = np.array(self.area, dtype=np.float64)
        if overlap.ndim != 3 or overlap.shape[1] != overlap.shape[2]:
            raise ResponseError(f"overlap has shape {overlap.shape}: (n_patches, n, n) is needed")
        if area.shape != overlap.shape[:1]:
            raise ResponseError(f"area has shape {area.shape}: {overlap.shape[:1]} is needed")
        bad = ~(np.isfinite(area) & (area > 0))
        if np.any(bad):
            raise ResponseError(f"area = {area[bad].flat[0]!r} m² must be finite and positive")
        for index, matrix in enumerate(overlap):
            largest = np.max(np.abs(matrix))
            if not np.isfinite(largest):
                raise ResponseError(f"overlap of patch {index} has values that are not finite")
            if np.max(np.abs(matrix - matrix.T)) > 1e-10 * largest:
                raise ResponseError(f"overlap of patch {index} is not symmetric")
        object.__setattr__(self, "overlap", overlap)
        object.__setattr__(self, "area", area)

    def factors(self, cutoff: float) -> list[Array]:
        """Return U_p (n, rank_p) [m] of each patch with D_p = U_p U_pᵀ.

        Eigenvalues of D_p below `cutoff` times the largest are dropped.
        """
        factors = []
        for index, matrix in enumerate(self.overlap):
            value, vector = np.linalg.eigh((matrix + matrix.T) / 2)
            if value[0] < -1e-10 * value[-1]:
                raise ResponseError(
                    f"overlap of patch {index} has the eigenvalue {value[0]:g} m² "
                    f"beside {value[-1]:g} m²: an integral of φ φᵀ has none below zero"
                )
            kept = value > cutoff * value[-1]
            factors.append(vector[:, kept] * np.sqrt(value[kept]))
        return factors


@dataclass(frozen=True)
class Response:
    """PSDs of the panel's motion at its points.

    Parameters
    ----------
    frequency
        (nf,) [Hz].
    cross_psd
        (nf, n_points, m, m) one-sided cross-PSDs, E[a b*] per Hz, of the m motions at each point:
        the deflection w [m] first, then those that were asked for beside it (see `bare_panels`).
    """

    frequency: Array
    cross_psd: Complexes

    def under(self, pressure_factor: float) -> "Response":
        """Return the response to S_p times ``pressure_factor`` at every frequency."""
        return replace(self, cross_psd=pressure_factor * self.cross_psd)

    @property
    def displacement_psd(self) -> Array:
        """(nf, n_points) S_w [m²/Hz]."""
        psd: Array = np.ascontiguousarray(self.cross_psd[:, :, 0, 0].real, dtype=np.float64)
        return psd

    @property
    def velocity_psd(self) -> Array:
        """(nf, n_points) S_v = ω² S_w [(m/s)²/Hz]."""
        psd: Array = self.displacement_psd * (2 * np.pi * self.frequency[:, None]) ** 2
        return psd

    @property
    def acceleration_psd(self) -> Array:
        """(nf, n_points) S_a = ω⁴ S_w [(m/s²)²/Hz]."""
        psd: Array = self.displacement_psd * (2 * np.pi * self.frequency[:, None]) ** 4
        return psd

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
