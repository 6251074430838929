"""Modal force of a sound field over a panel.

The cross-PSD of the modal forces is S_f,ij(f) = S_p(f) G_ij(k), with S_p the one-sided PSD of the
pressure on the face [Pa²/Hz] and

    G_ij(k) = ∬ φ_i(x) γ(x − x′; k) φ_j(x′) dA dA′      [m⁴ for dimensionless shapes],

where γ is the coherence of the field and k = 2πf/c₀ the wavenumber [rad/m]. Fields:

- diffuse: γ = sin(kR)/(kR), R = |x − x′| (paper, Eq. 22), `diffuse_modal_force` for one k and
  `tabulate_diffuse` for all;
- uniform: γ = 1, one pressure everywhere;
- plane waves: γ = exp(−i k·(x − x′)), or the mean or coherent sum of several (`plane_waves`); along
  the panel (grazing) one is the field of a progressive-wave tube;
- uncorrelated: the unit matrix that the paper uses in place of Eq. 22, which depends on the
  mesh.

The panel is given by a quadrature: positions (nq, 2) [m], weights (nq,) [m²] and the values of
the n shapes there, (nq, n). Order 5 on elements that resolve the shapes is enough; tables condense
it to the Gauss points of the box round the panel (`pidpanel.geometry.plane_waves`), where plane
waves are products and their means over direction cost a quarter.
"""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.geometry.plane_mesh import cell_areas
from pidpanel.geometry.plane_waves import PanelQuadrature
from pidpanel.progress import with_progress
from pidpanel.sound.face import FoldedFace
from pidpanel.sound.plane_waves import PlaneWaves
from pidpanel.sound.spectrum import PressureReference, Spectrum, pressure_psd
from pidpanel.sound.wavenumber_table import (
    FieldError,
    Table,
    WavenumberTable,
    chebyshev_nodes,
    even_interpolation,
    node_count,
    spare_nodes,
)

# Largest error of an interpolated G_ij allowed, relative to √(max_k G_ii · max_k G_jj).
TABLE_TOLERANCE = 1e-9

# Plane waves evaluated together, so that memory stays at 256 nq values whatever k is.
DIRECTIONS_AT_ONCE = 256

# A face is condensed for wavenumbers up to this times those that drive it: it then errs by
# half of `FACE_ERROR`.
PLANE_WAVE_MARGIN = 2.0

# Error of the modal force of a plane wave over ∫|φ| dA, for a face that is condensed twice.
FACE_ERROR = 2e-10

SHAPES_CHECKED = 48  # shapes, spread over all, on which a table is compared with the direct sum


def wavenumber(frequency: ArrayLike, speed_of_sound: float) -> Array:
    """Return k = 2πf/c₀ [rad/m] from frequencies [Hz] and the speed of sound c₀ [m/s].

    Examples
    --------
    >>> round(float(wavenumber(64.90, 343.0)), 5)
    1.18886
    """
    return 2 * np.pi * np.asarray(frequency, dtype=np.float64) / speed_of_sound


def diffuse_modal_force(wavenumber: float, panel: PanelQuadrature) -> Array:
    """Return G (n, n) [m⁴] of a diffuse field at one wavenumber k [rad/m], as a sum of plane waves.

    sin(kR)/(kR) is the mean of exp(i k·(x − x′)) over all directions, so

        G = (1/2π) ∫₀¹ dμ ∫₀^2π dα Re(B Bᴴ),   B_i = ∫ φ_i exp(i k s n_α·x) dA,   s = √(1 − μ²).

    Gauss in μ = cos θ (half of an even rule, since the integrand is even in μ), equal steps in α
    (half the circle, since B turns into its conjugate on the other half). The sum itself is exact
    to about 1e-12; the quadrature over the panel is the caller's.
    """
    cosine, cosine_weight = half_gauss(wavenumber, panel.diameter)
    azimuth = half_circle(wavenumber, panel.diameter)
    radial = wavenumber * np.sqrt(1 - cosine**2)
    even, odd = transform(radial, azimuth, panel)
    root_weight = np.sqrt(cosine_weight / azimuth.size)[:, None, None]
    parts = np.concatenate([root_weight * even, root_weight * odd]).reshape(-1, even.shape[2])
    return parts.T @ parts


def diffuse_modal_force_on_grid(wavenumber: float, panel: PanelQuadrature) -> Array:
    """Return `diffuse_modal_force` of a face on a grid, as a condensed one is.

    By parity a quarter of the waves over a quarter of the points is enough: G = ∫₀¹ Ā(ks) dμ.
    """
    face = FoldedFace.from_grid(panel)
    cosine, weight = half_gauss(wavenumber, panel.diameter)
    force = np.zeros((panel.shape.shape[1],) * 2)
    for mu, share in zip(cosine, weight, strict=True):
        force += share * face.azimuthal_mean(wavenumber * np.sqrt(1 - mu**2), panel.diameter)
    return force


def tabulate_diffuse(
    wavenumber_max: float, panel: PanelQuadrature, nodes_in_k: int | None = None
) -> WavenumberTable:
    """Tabulate G of a diffuse field up to k_max [rad/m]; check the table against direct values.

    With k² = κ² + k² cos² θ, G is a mean of Ā(κ) = (1/2π) ∮ Re B Bᴴ dα over cos θ, and Ā, even and
    entire in κ, is computed once at the Chebyshev nodes of the table:

        G(k) = ∫₀¹ Ā(k √(1 − μ²)) dμ.

    Raises
    ------
    FieldError
        Where the table misses `diffuse_modal_force` at k_max or at mid-range by more than
        `TABLE_TOLERANCE` √(max_k G_ii · max_k G_jj), or by more than what is known of the face; or
        where the face is not condensed for twice k_max.
    """
    k_max = float(wavenumber_max)
    diameter = panel.diameter
    count = nodes_in_k or node_count(k_max, diameter)
    nodes = chebyshev_nodes(k_max, count)
    face = FoldedFace.from_panel(panel, PLANE_WAVE_MARGIN * k_max)
    to_force = np.empty((count, count))
    for index, k in enumerate(nodes):
        cosine, cosine_weight = half_gauss(k, diameter)
        to_force[index] = cosine_weight @ even_interpolation(
            k * np.sqrt(1 - cosine**2), k_max, count
        )
    n = panel.shape.shape[1]
    modal_force = np.empty((count, n, n))
    for index, k in with_progress(list(enumerate(nodes)), "wavenumbers of the sound"):
        modal_force[index] = face.azimuthal_mean(k, diameter)
    for row in range(n):  # in place: of a large panel this is most of the memory
        modal_force[:, row] = to_force @ modal_force[:, row]
    table = WavenumberTable(k_max, nodes, modal_force)
    sample = np.unique(np.linspace(0, n - 1, min(n, SHAPES_CHECKED)).astype(int))
    subset = WavenumberTable(k_max, nodes, modal_force[:, sample[:, None], sample])
    for k in (k_max, k_max / 2):  # neither is a node; the end of the range is the worst place
        checked = panel.of_shapes(sample)
        _check_table(subset, k, diffuse_modal_force(k, checked), checked)
    return table


def uniform_modal_force(panel: PanelQuadrature) -> Array:
    """Return G (n, n) [m⁴] of one pressure over the whole face: G_ij = ∫φ_i dA ∫φ_j dA."""
    force = panel.weight @ panel.shape
    return np.outer(force, force)


def plane_wave_modal_force(
    wavenumber: ArrayLike, waves: PlaneWaves, panel: PanelQuadrature
) -> Complexes:
    """Return G (nf, n, n) [m⁴] of plane waves at k (nf,) [rad/m], Hermitian.

    b_i = ∫ φ_i exp(−i k sin θ n_α·x) dA of each, with x from the middle of the box round the panel.
    """
    k = np.asarray(wavenumber, dtype=np.float64)
    forces = np.empty((k.size, waves.count, panel.shape.shape[1]), np.complex128)
    for wave, (incidence, azimuth) in enumerate(zip(waves.incidence, waves.azimuth, strict=True)):
        even, odd = transform(k * np.sin(incidence), np.array([azimuth]), panel)
        forces[:, wave] = (even - 1j * odd)[:, 0]
    return waves.modal_force(forces)


def tabulate_plane_waves(
    wavenumber_max: float, waves: PlaneWaves, panel: PanelQuadrature
) -> WavenumberTable:
    """Tabulate G of plane waves for 0 ≤ k ≤ k_max.

    Re G is even in k and Im G odd, so that the table interpolates Re G and Im G/k.

    Parameters and errors are those of `plane_wave_modal_force` and `tabulate_diffuse`.
    """
    k_max = float(wavenumber_max)
    nodes = chebyshev_nodes(k_max, node_count(k_max, panel.diameter))
    modal_force = plane_wave_modal_force(nodes, waves, panel)
    even = np.asarray(modal_force.real, np.float64)
    odd = np.asarray(modal_force.imag / nodes[:, None, None], np.float64)
    table = WavenumberTable(k_max, nodes, even, odd)
    for k in (k_max, k_max / 2):
        _check_table(table, k, plane_wave_modal_force([k], waves, panel)[0], panel)
    return table


def uncorrelated_modal_force(area: ArrayLike, shape: ArrayLike) -> Array:
    """Return G (n, n) [m⁴] of independent pressures lumped on elements or nodes (the paper's).

    G_ij = Σ_e (A_e φ_i(e)) (A_e φ_j(e)), the unit matrix in place of Eq. 22, of areas (ne,) [m²]
    and shapes (ne, n). It does not depend on frequency but **on the mesh**: each halving of the
    element edge lowers it by 6.02 dB, so it has no limit and is no sound field. For 30 × 20
    elements on 1.5 m × 1.0 m its PSD is below that of the diffuse field by 25.6 dB in mode (1,1) at
    its own frequency, by 14.6 dB in (3,1) and by 5.4 dB in (9,1). It serves to reproduce the paper.
    """
    area = np.asarray(area, dtype=np.float64)
    shape = np.asarray(shape, dtype=np.float64)
    force = area[:, None] * shape
    return force.T @ force


def lumped_area(vertex_position: ArrayLike, cells: Index) -> Array:
    """Return the area (n_vertices,) [m²] of each vertex: cells are shared equally by their corners.

    Examples
    --------
    >>> lumped_area([[0, 0], [2, 0], [2, 1], [0, 1]], np.array([[0, 1, 2, 3]])).tolist()
    [0.5, 0.5, 0.5, 0.5]
    """
    share = np.abs(cell_areas(vertex_position, cells)) / cells.shape[1]
    area = np.zeros(len(np.asarray(vertex_position)))
    np.add.at(area, cells, share[:, None])
    return area


def _check_table(
    table: WavenumberTable, k: float, direct: Complexes | Array, panel: PanelQuadrature
) -> None:
    """Refuse a table that misses the direct G at k by more than the tolerance.

    The force of a wave has an error of `FACE_ERROR` ∫|φ| dA: for shapes that long waves hardly
    excite, G is less accurate than the tolerance.
    """
    largest = np.sqrt(np.max(np.diagonal(table.even, axis1=1, axis2=2), axis=0))
    largest = np.maximum(largest, 1e-6 * largest.max())  # a shape that is not excited
    face_error = FACE_ERROR / TABLE_TOLERANCE * (panel.weight @ np.abs(panel.shape))
    miss = np.abs(table.matrix([k])[0] - direct)
    allowance = np.outer(largest, face_error)
    error = float(np.max(miss / (np.outer(largest, largest) + allowance + allowance.T)))
    if error > TABLE_TOLERANCE:
        raise FieldError(
            f"{table.wavenumber.size} nodes in k leave a relative error of {error:.1e} at "
            f"k = {k:g} rad/m; at most {TABLE_TOLERANCE:g} is allowed, use more nodes"
        )


def half_gauss(k: float, diameter: float) -> tuple[Array, Array]:
    """Return nodes and weights in μ on (0, 1), exact for even polynomials of degree 4·count − 1."""
    count = int(np.ceil(k * diameter / 4)) + spare_nodes(k * diameter)
    node, weight = np.polynomial.legendre.leggauss(2 * count)
    return node[count:], weight[count:]


def half_circle(k: float, diameter: float) -> Array:
    """Return equally spaced azimuths on [0, π) [rad]."""
    count = int(np.ceil(k * diameter / 2)) + spare_nodes(k * diameter)
    return np.pi * np.arange(count) / count


def transform(radial: Array, azimuth: Array, panel: PanelQuadrature) -> tuple[Array, Array]:
    """Return ∫ φ cos(κ n_α·x) dA and ∫ φ sin(κ n_α·x) dA, each (n_radial, n_azimuth, n) [m²].

    x is measured from the middle of the panel, so that both vary as slowly as possible with κ.
    """
    direction = np.stack([np.cos(azimuth), np.sin(azimuth)])
    distance = (panel.position - panel.center) @ direction  # (nq, n_azimuth)
    load = panel.weight[:, None] * panel.shape
    count = radial.size * azimuth.size
    even = np.empty((count, load.shape[1]))
    odd = np.empty_like(even)
    for start in range(0, count, DIRECTIONS_AT_ONCE):
        part = slice(start, min(start + DIRECTIONS_AT_ONCE, count))
        which_radial, which_azimuth = np.divmod(np.arange(part.start, part.stop), azimuth.size)
        phase = distance[:, which_azimuth] * radial[which_radial]
        even[part] = np.cos(phase).T @ load
        odd[part] = np.sin(phase).T @ load
    shape = (radial.size, azimuth.size, load.shape[1])
    return even.reshape(shape), odd.reshape(shape)


@dataclass(frozen=True)
class SoundExcitation:
    """A diffuse, plane, progressive, uniform or uncorrelated sound field.

    Implements `solve.excitation.Excitation`: S is the PSD of the pressure on the face [Pa²/Hz], G
    the modal force of the field [m⁴].
    """

    pressure: Spectrum
    table: Table  # G over wavenumber, which depends on the field (`sound.field`)
    speed: float  # speed of sound [m/s]
    # See `spectrum.pressure_psd`
    reference: PressureReference = "surface"
    loaded_sides: int = 1

    def spectrum(self, frequency: Array) -> Array:
        """Return S (nf,) [Pa²/Hz] at the frequencies (nf,) [Hz]."""
        return pressure_psd(self.pressure, frequency, self.reference, self.loaded_sides)

    def __call__(self, frequency: Array) -> Array | Complexes:
        """Return G (nf, n, n) [m⁴]."""
        return self.table.matrix(wavenumber(frequency, self.speed))

    def factors(self, frequency: Array) -> Array | Complexes | None:
        """Return L (nf, n, r) [m²] with G = L Lᴴ; None where r is not small."""
        return self.table.factors_at(wavenumber(frequency, self.speed))
