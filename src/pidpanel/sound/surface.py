"""Modal force of a sound field on the faces of a curved surface, each face alone.

G and its fields are those of `field`, with x on the surface and φ along its normal. A diffuse
field is a mean of plane waves from all sides,

    G(k) = (1/4π) ∮ Re(B Bᴴ) dΩ,    B_i = ∫ φ_i exp(i k n·x) dA.

In the axes of the surface exp(i k μ z) has the even part cos(kμz) and the odd part i sin(kμz).
Waves along μ and −μ differ in the sign of the odd one, so that their cross terms cancel:

    G(k) = ∫₀¹ [Ā_cos + Ā_sin](k √(1 − μ²)) dμ,

with Ā the azimuthal mean (`sound.face`) of the loads φ cos(kμz) and φ sin(kμz) on x and y. These
are sums over loads P_m(z/c) φ, which are condensed once for all k:
exp(i k μ z) = Σ_m (2m + 1) iᵐ j_m(kμc) P_m(z/c).
"""

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes
from pidpanel.geometry.plane_waves import PanelQuadrature, degree
from pidpanel.geometry.surface_waves import SurfaceQuadrature
from pidpanel.progress import with_progress
from pidpanel.sound.face import FoldedFace
from pidpanel.sound.field import half_gauss
from pidpanel.sound.radiation import SHORTEST_REACH
from pidpanel.sound.wavenumber_table import (
    FieldError,
    WavenumberTable,
    chebyshev_nodes,
    even_interpolation,
    node_count,
)

# Wavenumber to which loads are condensed over the largest of the sound.
MARGIN = 1.75

SERIES_END = 1e-13  # least coefficient of P_m that counts


def tabulate_diffuse_surface(wavenumber_max: float, surface: SurfaceQuadrature) -> WavenumberTable:
    """Tabulate G [m⁴] of a diffuse field for 0 ≤ k ≤ k_max [rad/m], as `field.tabulate_diffuse`."""
    k_max, diameter = float(wavenumber_max), surface.diameter
    nodes = chebyshev_nodes(k_max, node_count(k_max, diameter))
    faces = _faces(surface, MARGIN * k_max)
    force = [
        _diffuse_force(k, faces, surface.half_height, diameter)
        for k in with_progress(nodes.tolist(), "wavenumbers of the sound")
    ]
    return WavenumberTable(k_max, nodes, np.array(force))


def surface_force(wavenumber: float, surface: SurfaceQuadrature) -> Array:
    """Return G (n, n) [m⁴] of a diffuse field at one wavenumber [rad/m]."""
    faces = _faces(surface, MARGIN * wavenumber)
    return _diffuse_force(wavenumber, faces, surface.half_height, surface.diameter)


def _faces(surface: SurfaceQuadrature, wavenumber: float) -> list[FoldedFace]:
    """Condense the loads P_m(z/c) φ of even m and of odd m, (n_m, n_x, n_y, n) of each parity."""
    height = surface.half_height
    count = degree(wavenumber * height)
    place = surface.local[:, 2] / max(height, np.finfo(float).tiny)
    legendre = np.polynomial.legendre.legvander(place, count - 1)
    faces = []
    for polynomials in (legendre[:, ::2], legendre[:, 1::2])[:count]:
        parts = []
        for polynomial in polynomials.T:
            load = PanelQuadrature(
                surface.local[:, :2], surface.weight, polynomial[:, None] * surface.shape
            )
            parts.append(FoldedFace.from_panel(load, wavenumber))
        ee, eo, oe, oo = (np.stack(one) for one in zip(*(p.load for p in parts), strict=True))
        faces.append(FoldedFace(parts[0].x, parts[0].y, (ee, eo, oe, oo)))
    return faces


def _diffuse_force(k: float, faces: list[FoldedFace], height: float, diameter: float) -> Array:
    from scipy.special import spherical_jn  # slow to import, and a check needs none

    cosine, weight = half_gauss(k, diameter)
    force: Array = np.zeros(1)
    for first, face in enumerate(faces):
        order = first + 2 * np.arange(len(face.load[0]))
        sign = (2 * order + 1) * (-1.0) ** (order // 2)
        for mu, share in zip(cosine, weight, strict=True):
            series = sign * spherical_jn(order, k * mu * height)
            terms = np.abs(series) > SERIES_END
            ee, eo, oe, oo = (np.tensordot(series[terms], part[terms], 1) for part in face.load)
            wave = FoldedFace(face.x, face.y, (ee, eo, oe, oo))
            force = force + share * wave.azimuthal_mean(k * np.sqrt(1 - mu**2), diameter)
    return force


def surface_wave_force(
    wavenumber: ArrayLike, direction: ArrayLike, surface: SurfaceQuadrature
) -> Complexes:
    """Return b = ∫ φ exp(−i k d·x) dA (nf, n) [m²] of a plane wave at k (nf,) [rad/m].

    It runs along d (3,). x is measured from the middle of the surface.
    """
    unit = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    middle = (surface.position.min(axis=0) + surface.position.max(axis=0)) / 2
    distance = (surface.position - middle) @ unit
    load = surface.weight[:, None] * surface.shape
    phases = [k * distance for k in np.atleast_1d(np.asarray(wavenumber, dtype=np.float64))]
    return np.array([np.cos(phase) @ load - 1j * (np.sin(phase) @ load) for phase in phases])


def tabulate_surface_wave(
    wavenumber_max: float, direction: ArrayLike, surface: SurfaceQuadrature
) -> WavenumberTable:
    """Tabulate G = b bᴴ [m⁴] of one plane wave along d (3,), as `field.tabulate_plane_wave`."""
    nodes = chebyshev_nodes(wavenumber_max, node_count(wavenumber_max, surface.diameter))
    force = surface_wave_force(nodes, direction, surface)
    square = force[:, :, None] * force[:, None, :].conj()
    odd = np.asarray(square.imag / nodes[:, None, None], np.float64)
    return WavenumberTable(wavenumber_max, nodes, np.asarray(square.real, np.float64), odd)


def tabulate_surface_mass(
    wavenumber_max: float, reach: float, surface: SurfaceQuadrature
) -> WavenumberTable:
    """Tabulate V [m³] of the air on one face, as `radiation.tabulate_added_mass`, up to k_max.

    The wave is that of a flat face with R across space. Then V follows from G at all wavenumbers q
    (the transform of cos(kR)/R in space),

        V(k) = (1/π²) ⨍ G(q) q²/(q² − k²) dq,

    with G → 2π/q² ∫ φ_i φ_j dA beyond the `reach` K [rad/m], which exceeds the wavenumbers of the
    shapes and k_max.
    """
    if reach < SHORTEST_REACH * wavenumber_max:
        raise FieldError(
            f"reach = {reach:g} rad/m: the air of a surface to {wavenumber_max:g} rad/m needs at "
            f"least {SHORTEST_REACH * wavenumber_max:g}"
        )
    table = tabulate_diffuse_surface(reach, surface)
    count = table.wavenumber.size
    nodes = chebyshev_nodes(wavenumber_max, node_count(wavenumber_max, surface.diameter))
    node, weight = np.polynomial.legendre.leggauss(4 * count)
    q, weight = reach / 2 * (1 + node), reach / 2 * weight
    between, direct = (even_interpolation(points, reach, count) for points in (q, nodes))
    root = np.sqrt(surface.weight)[:, None] * surface.shape
    overlap = root.T @ root
    volume = np.empty((nodes.size, *overlap.shape))
    for index, k in enumerate(nodes):
        share = weight / (q**2 - k**2)
        # of 1/(q² − k²) the principal value up to K is the logarithm, its rest the opposite
        logarithm = np.log((reach - k) / (reach + k)) / (2 * k)
        weights = share * q**2 @ between + k**2 * (logarithm - share.sum()) * direct[index]
        force = np.tensordot(weights, table.even, axes=1)
        volume[index] = (force - 2 * np.pi * logarithm * overlap) / np.pi**2
    return WavenumberTable(wavenumber_max, nodes, volume)


def uniform_surface_force(surface: SurfaceQuadrature) -> Array:
    """Return G (n, n) [m⁴] of one pressure over the whole face."""
    force = surface.weight @ surface.shape
    return np.outer(force, force)
