"""A thin panel with free edges in air: one matrix Z(k) for its load, its resistance and its mass.

The pressure jumps over the panel by μ and is ±μ/2 on its faces. In wavenumbers κ a jump moves the
air along the normal by the velocity γ μ̂/(2iωρ), γ = √(κ² − k²), outside the panel as well. With
functions ψ for the jump, which fall to the edge as √distance, and shapes φ of the panel

    A(k) = (2π)⁻² ∫ ψ̂* (γ/2) ψ̂ᵀ d²κ,    C = ∫ ψ φ dA,    Z(k) = Cᵀ A⁻¹ C    [m³],

complex and symmetric (Galerkin's method for the hypersingular equation of a screen, Stephan 1987).
It gives mass ρ Re Z and resistance ρω |Im Z| of the air on both faces. By reciprocity (Shorter and
Langley 2005) a diffuse room loads the shapes with (4π/k) |Im Z| per mean square of its pressure.
Far above ka = 1 both are those of two independent faces: Z → 2V − ik G/π with V and G of one face
in a baffle (`radiation`, `field`).

Behind a panel at the distance d from a rigid wall is its image: γ/2 becomes γ/2 (1 − exp(−2γd)).

With P(κ) = (1/2π) ∮ ψ̂ψ̂* dα, even and entire in κ, A = (1/4π) ∫ P κ γ dκ. The part of k = 0 is
integrated once; what is left falls fast:

    4π A(k) = ∫ P κ² dκ − ∫ P κ (κ − γ) dκ,    γ = −i √(k² − κ²) for κ < k.

A is entire in k as well, its real part even and its imaginary part odd. Z is not: its poles, the
resonances of the air round the edges, lie about 2.2/L below the real axis, so that a table of Z has
more nodes.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Any, Protocol

import numpy as np

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.geometry.plane_mesh import rectangle_corners
from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.geometry.surface_waves import SurfaceQuadrature
from pidpanel.sound.outline import OutlineJumps
from pidpanel.sound.plane_waves import PlaneWaves
from pidpanel.sound.rectangle import RectangleJumps
from pidpanel.sound.triangles import SurfaceJumps
from pidpanel.sound.wavenumber_table import (
    FieldError,
    WavenumberTable,
    chebyshev_nodes,
    even_interpolation,
    node_count,
)

# Nodes of a table of Z per kL, and beyond that.
NODES_PER_REACH, MORE_NODES = 2.1, 16

# Error of the interpolated load over the largest, the wavenumbers at which it is checked, the ratio
# of nodes from one attempt to the next, and the largest error that is accepted after the last.
NODE_ERROR, CHECKED, MORE, ATTEMPTS, LARGEST_ERROR = 3e-4, 9, 1.5, 5, 0.01


ROUNDING = 1e-9  # of A over its largest eigenvalue


class Jumps(Protocol):
    """Functions ψ of the jump, in blocks that do not interact."""

    @property
    def diameter(self) -> float:
        """L [m]."""

    def couplings(self, panel: Any) -> list[Array]:
        """Return ∫ ψ φ dA (n, n_shapes) [m²] of the shapes of a quadrature."""

    def waves(self, wavevector: Array) -> list[Complexes]:
        """Return ∫ ψ exp(−iκ·x) dA (k, n) [m²]; on triangles its normal derivative [m]."""


FlatJumps = RectangleJumps | OutlineJumps

Quadrature = PanelQuadrature | SurfaceQuadrature

# Vertices and cells of a mesh: bytes, shape and type of both.
Outline = tuple[tuple[bytes, tuple[int, ...], str], ...]


def jumps_of(vertices: Array, cells: Index, wavenumber: float) -> FlatJumps:
    """Return functions on a panel with this mesh for waves to κ [rad/m], or fewer."""
    corners = rectangle_corners(vertices, cells)
    if corners is None:
        return OutlineJumps.of_mesh(vertices, cells, wavenumber)
    return RectangleJumps.of_box(*corners, wavenumber)


@dataclass(frozen=True)
class FreePanel:
    """A panel with free edges up to a wavenumber, alone or before a rigid wall."""

    jumps: Jumps
    wavenumber_max: float  # [rad/m]
    wall: float  # d [m]; ∞ without one
    operator: list[WavenumberTable]  # A of each block [m]

    @classmethod
    def of_jumps(cls, jumps: FlatJumps, wavenumber_max: float, wall: float = np.inf) -> FreePanel:
        """Tabulate A of functions for 0 ≤ k ≤ k_max [rad/m]."""
        from scipy.special import expn  # slow to import, and a check needs none

        panel = cls(jumps, wavenumber_max, wall, [])
        reach = jumps.reach
        count = node_count(reach, jumps.diameter)
        nodes = chebyshev_nodes(wavenumber_max, node_count(wavenumber_max, panel.length))
        static = _static(reach, count)
        # what a wall leaves of the part beyond K, which falls as κ⁻² without one
        beyond = 1 - expn(2, 2 * reach * min(wall, 1e3))
        moving = np.array([_moving(k, reach, count, wall) for k in nodes]) / (4 * np.pi)
        for mean, tail in zip(jumps.means(), jumps.tails(), strict=True):
            flat, shape = mean.reshape(count, -1), (nodes.size, *mean.shape[1:])
            at_rest = (static @ flat + beyond * tail.ravel()) / (4 * np.pi)
            even = (at_rest - moving.real @ flat).reshape(shape)
            odd = (-(moving.imag / nodes[:, None]) @ flat).reshape(shape)
            _check_signs(even[-1], odd[[0, -1]])
            panel.operator.append(WavenumberTable(wavenumber_max, nodes, even, odd))
        return panel

    def impedance(self, wavenumber: float, couplings: list[Array]) -> Complexes:
        """Return Z (n, n) [m³] at k [rad/m] of shapes with these C; Im Z is positive."""
        total = np.zeros((couplings[0].shape[1],) * 2, np.complex128)
        for table, coupling in zip(self.operator, couplings, strict=True):
            operator = table.matrix([wavenumber])[0]
            total += coupling.T @ np.linalg.solve(operator, coupling)
        return total

    def wave_forces(
        self, wavenumber: float, incidence: Array, azimuth: Array, couplings: list[Array]
    ) -> Complexes:
        """Return the forces (nw, n) [m²] of plane waves of unit pressure on shapes with these C.

        The angles (nw,) are those of `field.plane_wave_modal_force`; a wall lies behind the panel.
        """
        forces = np.zeros((incidence.size, couplings[0].shape[1]), np.complex128)
        waves = self._slopes(wavenumber * _directions(incidence, azimuth))
        for table, coupling, wave in zip(self.operator, couplings, waves, strict=True):
            operator = table.matrix([wavenumber])[0].conj()
            forces += wave @ np.linalg.solve(operator, coupling)
        return forces

    def _slopes(self, wavevector: Array) -> list[Complexes]:
        """Return ∫ ψ ∂p/∂n dA (k, n) [m] of waves κ (k, 3) [rad/m] and of their reflections."""
        normal = wavevector[:, 2]
        reflected = 1.0 if np.isinf(self.wall) else 1 - np.exp(-2j * normal * self.wall)
        factor = (-1j * normal * reflected)[:, None]
        return [factor * wave for wave in self.jumps.waves(wavevector[:, :2])]

    @property
    def length(self) -> float:
        """Length [m] with which A varies over k: that of the panel, or of its image."""
        return float(np.hypot(self.jumps.diameter, _image_distance(self.wall)))

    def tabulated(self, values: Callable[[float], tuple[Any, ...]]) -> tuple[Any, ...]:
        """Return arrays over the nodes of tables, that `values` gives of k [rad/m].

        There are more nodes until the first, over k², is interpolated within `NODE_ERROR`: before a
        close wall the resonances of the gap are sharp.
        """
        k_max = self.wavenumber_max
        count = int(NODES_PER_REACH * k_max * self.length) + MORE_NODES
        tried = checked(k_max)
        expected = np.array([np.diagonal(values(k)[0]) / k**2 for k in tried])
        for attempt in range(ATTEMPTS):
            nodes = chebyshev_nodes(k_max, count)
            arrays = [np.array(rows) for rows in zip(*map(values, nodes), strict=True)]
            diagonal = np.diagonal(arrays[0], axis1=1, axis2=2) / nodes[:, None] ** 2
            missed = np.abs(even_interpolation(tried, k_max, count) @ diagonal - expected)
            error = float(np.max(missed / np.max(np.abs(diagonal), axis=0)))
            if error < NODE_ERROR or attempt == ATTEMPTS - 1:
                break
            count = int(MORE * count)
        if error > LARGEST_ERROR:
            raise FieldError(
                f"{count} wavenumbers leave an error of {error:.1%} of the load; the resonances of "
                "the air behind the panel are too sharp: use a lower frequency or a farther wall"
            )
        return nodes, *arrays


@dataclass(frozen=True)
class FreeSurface(FreePanel):
    """A thin surface of any form with free edges; angles of waves are those from z and x."""

    @classmethod
    def of_hats(cls, jumps: SurfaceJumps, wavenumber_max: float) -> FreeSurface:
        """Tabulate A of hats for 0 ≤ k ≤ k_max [rad/m]."""
        return cls(jumps, wavenumber_max, np.inf, [jumps.operator(wavenumber_max)])

    def _slopes(self, wavevector: Array) -> list[Complexes]:
        return self.jumps.waves(wavevector)


@lru_cache(maxsize=2)
def tabulated_panel(
    outline: Outline, resolved: float, k_max: float, wall: float, share: float
) -> FreePanel:
    """Return the panel of an outline with free edges, see `SurfaceJumps.of_surface`.

    Functions resolve waves to a wavenumber [rad/m]; a wall [m] is only allowed behind a flat one.
    """
    vertices, cells = (np.frombuffer(a, kind).reshape(shape) for a, shape, kind in outline)
    if vertices.shape[1] == 3:
        if np.isfinite(wall):
            raise ValueError("surroundings: a wall is only allowed behind a flat structure")
        hats = SurfaceJumps.of_surface(vertices, cells, resolved, share)
        return FreeSurface.of_hats(hats, min(k_max, hats.wavenumber))
    jumps = jumps_of(vertices, cells, resolved)
    return FreePanel.of_jumps(jumps, min(k_max, jumps.wavenumber), wall)


def _directions(incidence: Array, azimuth: Array) -> Array:
    sine = np.sin(incidence)
    return np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), np.cos(incidence)], axis=1)


def _check_signs(at_rest: Array, odd: Array) -> None:
    """Raise an error unless air of a long wave has mass, and none gives energy: Re A > 0 ≥ Im A."""
    mass = np.linalg.eigvalsh((at_rest + at_rest.T) / 2)
    source = np.linalg.eigvalsh((odd + odd.swapaxes(1, 2)) / 2).max(axis=1)
    if not (mass[0] > 0 and np.all(source <= ROUNDING * mass[-1])):
        raise FieldError(
            f"the air on free edges has a negative mass or resistance ({mass[0]:.3g} m, "
            f"{-source.max():.3g} m²): use a mesh with elements of one size"
        )


def _static(reach: float, count: int) -> Array:
    """Return the weights (count,) of P at its nodes in ∫ P κ² dκ up to K."""
    node, weight = np.polynomial.legendre.leggauss(2 * count)
    kappa = reach / 2 * (1 + node)
    return (reach / 2 * weight * kappa**2) @ even_interpolation(kappa, reach, count)


def _moving(k: float, reach: float, count: int, wall: float) -> Complexes:
    """Return the weights (count,) of P at its nodes in ∫ P κ (κ − γ (1 − exp(−2γd))) dκ up to K.

    κ = k sin u below k, κ = k cosh t above: the root of γ is then smooth.
    """
    further = int(np.ceil(k * _image_distance(wall) / 2))
    node, weight = np.polynomial.legendre.leggauss(count + 20 + further)
    angle = np.pi / 4 * (1 + node)
    inside, gamma = k * np.sin(angle), -1j * k * np.cos(angle)
    weights = np.pi / 4 * weight * 1j * gamma * inside * (inside - gamma * _image(gamma, wall))
    total: Complexes = weights @ even_interpolation(inside, reach, count)
    longest = np.arccosh(reach / k)
    node, weight = np.polynomial.legendre.leggauss(4 * count)
    stretch = longest / 2 * (1 + node)
    gamma, outside = k * np.sinh(stretch), np.minimum(k * np.cosh(stretch), reach)
    remainder = k * np.exp(-stretch) + gamma * (1 - _image(gamma, wall))
    weights = longest / 2 * weight * gamma * outside * remainder
    return total + weights @ even_interpolation(outside, reach, count)


def _image_distance(wall: float) -> float:
    """Return the distance of the image [m]; 0 without one."""
    return 0.0 if np.isinf(wall) else 2 * wall


def _image(gamma: Array | Complexes, wall: float) -> Array | Complexes:
    """Return 1 − exp(−2γd)."""
    return np.ones_like(gamma) if np.isinf(wall) else -np.expm1(-2 * gamma * wall)


def tabulate_diffuse_room(
    panel: FreePanel, face: Quadrature
) -> tuple[WavenumberTable, WavenumberTable]:
    """Tabulate the load of a diffuse room and the mass of the air for 0 ≤ k ≤ k_max.

    Both as those of one of two independent faces: G = (π/k) |Im Z| [m⁴], of which the load is four
    times per PSD of the room, and V = Re Z/2 [m³].
    """
    couplings = panel.jumps.couplings(face)

    def values(k: float) -> tuple[Array, Array]:
        impedance = panel.impedance(k, couplings)
        impedance = (impedance + impedance.T) / 2
        return np.pi / k * impedance.imag, impedance.real / 2

    nodes, force, volume = panel.tabulated(values)
    k_max = panel.wavenumber_max
    force /= nodes[:, None, None] ** 2  # of long waves |Im Z| goes with k³
    return WavenumberTable(k_max, nodes, force, power=2), WavenumberTable(k_max, nodes, volume)


def mesh_error(panel: FreeSurface, coarser: FreeSurface, surface: SurfaceQuadrature) -> Array:
    """Return the relative error by the mesh of the load of each shape at `checked` k (nk, n).

    From a coarser mesh of the same surface, for an error that goes with the edges to 3/2.
    """
    loads = []
    for mesh in (panel, coarser):
        couplings = mesh.jumps.couplings(surface)
        tried = checked(panel.wavenumber_max)
        loads.append([np.diagonal(mesh.impedance(k, couplings)).imag for k in tried])
    fine, coarse = np.array(loads)
    ratio = len(panel.operator[0].even[0]) / len(coarser.operator[0].even[0])
    return np.abs(coarse / fine - 1) / (ratio**0.75 - 1)


def checked(wavenumber_max: float) -> Array:
    """Return the wavenumbers (nk,) [rad/m] at which tables and meshes are checked."""
    return wavenumber_max * (np.arange(CHECKED) + 0.5) / CHECKED


def plane_wave_force(
    panel: FreePanel, k: float, waves: PlaneWaves, couplings: list[Array]
) -> Complexes:
    """Return G/4 (n, n) [m⁴] of the forces of plane waves of unit pressure together."""
    forces = panel.wave_forces(k, waves.incidence, waves.azimuth, couplings)
    return waves.modal_force(forces / 2)


def tabulate_free_plane_waves(
    panel: FreePanel, face: Quadrature, waves: PlaneWaves
) -> WavenumberTable:
    """Tabulate G [m⁴] of plane waves, as that of one of two independent faces.

    The load is four times that per PSD of the waves' pressure.
    """
    couplings = panel.jumps.couplings(face)

    def values(k: float) -> tuple[Complexes]:
        return (plane_wave_force(panel, k, waves, couplings),)

    nodes, square = panel.tabulated(values)
    square /= nodes[:, None, None] ** 2
    odd = square.imag / nodes[:, None, None]
    return WavenumberTable(panel.wavenumber_max, nodes, square.real.copy(), odd, power=2)
