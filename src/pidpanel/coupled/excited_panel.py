"""The panel of a study under its excitation, with the patches of a scenario."""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from scipy.interpolate import CubicSpline
from scipy.linalg import eigh

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled.coupled_panel import CoupledPanel, CoupledPatch, bare_psd
from pidpanel.coupled.scenario import CoupledScenario, RunSettings
from pidpanel.coupled.softening import RmsMotion, Softened, softened, softest
from pidpanel.damping.models import FilledDamper
from pidpanel.panel.basis import PanelBasis, patch_areas
from pidpanel.panel.matrices import StoredPlate
from pidpanel.solve.base_motion import UNIT, BaseExcitation, Translation
from pidpanel.solve.basis_error import modal_basis
from pidpanel.solve.excitation import Excitation, ModalForce
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.panel import deflection_at_points
from pidpanel.solve.receptances import patch_stiffness, weighted_sum
from pidpanel.solve.source import PatchParts
from pidpanel.sound.radiation import Air

# Frequencies at which air and dampers without particles are evaluated: the resonances of a gap of
# 5 cm have damping ratios of 5 %.
NODES = 160

# Least inertia of an oscillator over the mass of its shape with the mean air.
LEAST_INERTIA = 0.2


@dataclass(frozen=True)
class LoadedShapes:
    """Oscillators, and their shapes in those of the bare panel."""

    modal: ModalBasis
    # (n, k) new shapes as columns; None where they are those of the bare panel
    vectors: Array | None

    def shape(self, values: Array) -> Array:
        """Return shapes (k, n) of the bare panel as those of here."""
        return values if self.vectors is None else np.asarray(values @ self.vectors)

    def columns(self, values: Array) -> Array:
        """Return forces (…, n, r) on the shapes of the bare panel as those on these."""
        return values if self.vectors is None else np.asarray(self.vectors.T @ values)

    def square(self, matrix: Array | Complexes) -> Array | Complexes:
        """Return matrices (…, n, n) on the shapes of the bare panel as those on these."""
        if self.vectors is None:
            return matrix
        return self.vectors.T @ matrix @ self.vectors


def loaded_shapes(
    modal: ModalBasis,
    extent: tuple[float, float],
    added: Callable[[Array], Complexes],
) -> LoadedShapes:
    """Return the oscillators of a panel with air and dampers that are not integrated.

    The panel moves in shapes of its own, those of its mass with the added one, a mean over the
    logarithm of frequency. Each shape alone has the dynamic stiffness k − ω²m(ω) + iωc(ω), and an
    oscillator for each of its resonances, with their frequency, inertia m + (ω/2) dm/dω and
    resistance c. Before a close wall these are those of the panel and of the air in the gap. What
    couples the shapes is left out: the particles are seen in that motion, and the response of the
    panel with their C_e and m_a has the whole matrices (`ExcitedPanel.whole`).

    Parameters
    ----------
    extent
        Lowest and highest frequency [Hz].
    added
        Dynamic stiffness (nf, n, n) [N/m] of air and dampers at frequencies (nf,) [Hz].
    """
    nodes = np.geomspace(*extent, NODES)
    parts = np.array_split(nodes, NODES // 10)  # memory of a large panel
    mass = sum((-added(f).real / (2 * np.pi * f[:, None, None]) ** 2).sum(axis=0) for f in parts)
    square, vectors = eigh(
        np.diag(modal.modal_mass * modal.angular_frequency**2),
        np.diag(modal.modal_mass) + mass / NODES,
    )
    stiffness = modal.dynamic_stiffness(nodes) @ vectors**2 + np.concatenate(
        [np.einsum("in,fij,jn->fn", vectors, added(f), vectors, optimize=True) for f in parts]
    )
    rows = [_resonances(nodes, *of_shape) for of_shape in zip(square, stiffness.T, strict=True)]
    natural, inertia, damping = np.concatenate(rows).T
    columns = np.repeat(vectors, [len(of_shape) for of_shape in rows], axis=1)
    return LoadedShapes(_oscillators(natural, inertia, damping), columns)


def _resonances(nodes: Array, square: float, stiffness: Complexes) -> Array:
    """Return frequency [Hz], inertia [kg] and resistance [N s/m] of each resonance of a shape.

    Of its dynamic stiffness at nodes [Hz], k of which is given; where it is on one side of the
    nodes, as if it had the mass and the resistance of the nearest one there.
    """
    omega = 2 * np.pi * nodes
    loss, inverse = stiffness.imag / omega, omega[::-1] ** -2
    # k/ω² − m over 1/ω²: a straight line of one mass
    curve = CubicSpline(inverse, (stiffness.real / omega**2)[::-1])
    roots = curve.roots(extrapolate=False)
    roots = roots[curve(roots, 1) > 0]
    inertia, resonance = curve(roots, 1) * roots, roots**-0.5 / (2 * np.pi)
    losses = np.interp(np.log(resonance), np.log(nodes), loss)
    rows = list(np.transpose([resonance, np.maximum(inertia, LEAST_INERTIA), losses]))
    for end, is_beyond in ((0, stiffness[0].real < 0), (-1, stiffness[-1].real > 0)):
        if is_beyond:
            mass = max((square - stiffness[end].real) / omega[end] ** 2, LEAST_INERTIA)
            rows.append(np.array([np.sqrt(max(square, 0.0) / mass) / (2 * np.pi), mass, loss[end]]))
    return np.array(rows)


def _oscillators(natural: Array, mass: Array, damping: Array) -> ModalBasis:
    """Return oscillators; one at rest has no damping of its own."""
    omega = 2 * np.pi * natural
    ratio = np.divide(damping, 2 * mass * omega, out=np.full_like(omega, 1e-6), where=omega > 0)
    return ModalBasis(natural, mass, ratio)


@dataclass(frozen=True)
class Stations:
    """Points of a patch where cells are simulated, each representing a part of its area."""

    point: Index  # (k,) index of each among the points of the patch
    area: Array  # (k,) area of its part [m²]; they add up to that of the patch


def stations_of(position: Array, weight: Array, count: int) -> Stations:
    """Return stations of a patch of any outline.

    The points of a quadrature are halved along the longer side of their extent, in proportion to
    the number of stations in each half, until each part has one: the point nearest its middle.
    The force of its cells acts on the modes as ∫ φ p dA ≈ Σ φ(x_k) a_k p_k, the midpoint rule.

    Examples
    --------
    >>> x = np.array([[0.1, 0.0], [0.2, 0.0], [0.3, 0.0], [0.7, 0.0], [0.8, 0.0], [0.9, 0.0]])
    >>> found = stations_of(x, np.full(6, 0.5), 2)
    >>> found.point.tolist(), found.area.tolist()
    ([1, 4], [1.5, 1.5])
    """
    if not 1 <= count <= len(weight):
        raise ValueError(f"{count} stations of a patch with {len(weight)} points")
    point, area = [], []
    for part in _parts(position, weight, np.arange(len(weight)), count):
        middle = weight[part] @ position[part] / weight[part].sum()
        nearest = np.argmin(((position[part] - middle) ** 2).sum(axis=1))
        point.append(part[nearest])
        area.append(weight[part].sum())
    return Stations(np.array(point), np.array(area))


def _parts(position: Array, weight: Array, part: Index, count: int) -> list[Index]:
    if count == 1:
        return [part]
    first = (count + 1) // 2
    extent = np.ptp(position[part], axis=0)
    # rounded, so that points of one column do not differ in their last digits
    size = max(float(extent.max()), 1e-300)
    along = np.round(position[part] / size, 9)
    axis = int(np.argmax(np.round(extent / size, 6)))
    order = np.lexsort((*np.delete(along, axis, axis=1).T, along[:, axis]))
    share = np.cumsum(weight[part][order]) / weight[part].sum()
    cut = int(np.searchsorted(share, first / count - 1e-9)) + 1
    cut = min(max(cut, first), len(part) - (count - first))
    halves = (part[order[:cut]], first), (part[order[cut:]], count - first)
    return [piece for half, number in halves for piece in _parts(position, weight, half, number)]


LINES_PER_BANDWIDTH = 3.0  # of rms values within 1e-3

PARTS = 64  # parts of a patch over which the own force is summed


@dataclass(frozen=True)
class ExcitedPanel:
    """The panel of a study under its excitation."""

    settings: RunSettings
    basis: PanelBasis
    plate: StoredPlate
    vectors: Array  # (n_free, n) its shapes but for a translation, which is then the last
    excitation: Excitation  # at the level of the study
    air: Air | None  # the air that the panel moves; None where it is left out
    translation: Translation = UNIT  # of its supports

    @cached_property
    def modal(self) -> ModalBasis:
        """The shapes with the damping ratio of the bare panel."""
        return modal_basis(
            self.basis, self.settings.damping_ratio, self.settings.frequency_range[1]
        )

    @cached_property
    def coarse_frequency(self) -> Array:
        """(nf,) lines that give rms values within 1e-3 [Hz]."""
        span = self.settings.frequency_range
        ratio = self.settings.damping_ratio.smallest(*span)
        return frequency_grid(*span, ratio, lines_per_bandwidth=LINES_PER_BANDWIDTH)

    @property
    def diameter(self) -> float:
        """Diameter of the panel [m]."""
        return float(np.linalg.norm(np.ptp(self.basis.vertex_position, axis=0)))

    def patch(self, name: str, cell_area: float, shapes: LoadedShapes) -> CoupledPatch:
        """Return a patch with its simulated cells of an area [m²]."""
        basis, settings = self.basis, self.settings
        index = basis.patch_names.index(name)
        per_cell = len(self.plate.quadrature_weight) // len(basis.cells)
        elements = np.flatnonzero(basis.cell_in_patch[index])
        rows = (elements[:, None] * per_cell + np.arange(per_cell)).ravel()
        position, weight = self.plate.quadrature_position[rows], self.plate.quadrature_weight[rows]

        def shape(points: Index) -> Array:
            values = np.asarray(self.plate.at_quadrature[rows[points]] @ self.vectors)
            moved = np.broadcast_to(self.translation.quadrature, len(self.plate.quadrature_weight))
            further = len(self.modal.modal_mass) - values.shape[1]
            translation = np.repeat(moved[rows[points], None], further, axis=1)
            return shapes.shape(np.hstack([values, translation]))

        stations = stations_of(position, weight, settings.stations)
        parts = stations_of(position, weight, min(PARTS, len(weight)))
        cells = settings.cells // settings.stations
        return CoupledPatch(
            shape=np.repeat(shape(stations.point), cells, axis=0),
            area=np.repeat(stations.area / cells, cells),
            position=np.repeat(position[stations.point], cells, axis=0),
            cell_area=cell_area,
            overlap=np.asarray(shapes.square(basis.patch_overlap[index])),
            parts=PatchParts(shape(parts.point), parts.area, position[parts.point]),
        )

    def added(self, scenario: CoupledScenario) -> Callable[[Array], Complexes] | None:
        """Return the dynamic stiffness of air and dampers that are not integrated."""
        parts = [self._stiffness(*item, scenario.factor) for item in scenario.dampers.items()]
        parts += [] if self.air is None else [self.air]
        return (lambda f: np.sum([part(f) for part in parts], axis=0)) if parts else None

    def _stiffness(
        self, patch: str, damper: FilledDamper, factor: float
    ) -> Callable[[Array], Complexes]:
        """Return the dynamic stiffness of a damper at the motion of the bare patch."""
        index = self.basis.patch_names.index(patch)
        overlap, area = self.basis.patch_overlap[index], patch_areas(self.basis)[index]
        square, vector = np.linalg.eigh(overlap)  # D = E Eᵀ
        frequency, columns = self.coarse_frequency, vector * np.sqrt(np.maximum(square, 0.0))
        psds = bare_psd(self.modal, self.excitation, columns.T, frequency, self.air)
        psd = psds.sum(axis=1) / area
        mean_square = np.trapezoid((2 * np.pi * frequency) ** 4 * psd, frequency)
        gamma = float(np.sqrt(2 * factor * mean_square)) / STANDARD_GRAVITY

        def stiffness(frequency: Array) -> Complexes:
            value, mass, _ = damper.damping(frequency, gamma)
            parts = value[None], mass[None]
            return weighted_sum(patch_stiffness(frequency, *parts), overlap[None])

        return stiffness

    def with_patches(self, scenario: CoupledScenario) -> CoupledPanel:
        """Return the panel of a run with the patches of a scenario, at its level."""
        added, shapes = self.added(scenario), LoadedShapes(self.modal, None)
        if added is not None:
            shapes = loaded_shapes(self.modal, self.settings.frequency_range, added)
        return self._panel(scenario, shapes)

    def whole(self, scenario: CoupledScenario) -> CoupledPanel:
        """Return the same panel with all of its air and dampers."""
        panel = self._panel(scenario, LoadedShapes(self.modal, None))
        return replace(panel, added=self.added(scenario))

    def _panel(self, scenario: CoupledScenario, shapes: LoadedShapes) -> CoupledPanel:
        excitation = self.excitation
        return CoupledPanel(
            modal=shapes.modal,
            points=shapes.shape(deflection_at_points(self.basis)),
            patches=[
                self.patch(patch.name, patch.beds[0].packing.cell_area, shapes)
                for patch in scenario.patches
            ],
            excitation=ModalForce(
                lambda frequency: scenario.factor * excitation.spectrum(frequency),
                lambda frequency: shapes.square(excitation(frequency)),
                # of base motion G is not resolved: the force on the table is 1e8 times the others
                (lambda frequency: shapes.columns(excitation.factors(frequency)))
                if isinstance(excitation, BaseExcitation)
                else None,
            ),
        )

    def moduli(self, scenario: CoupledScenario, panel: CoupledPanel) -> list[Softened]:
        """Return the contacts of each patch."""
        frequency, omega = self.coarse_frequency, 2 * np.pi * self.coarse_frequency
        moduli = []
        for simulated, patch in zip(scenario.patches, panel.patches, strict=True):
            psds = bare_psd(panel.modal, panel.excitation, patch.shape, frequency)
            psd = psds @ patch.area / patch.area.sum()
            squares = [float(np.trapezoid(omega**k * psd, frequency)) for k in (2, 4)]
            particle = simulated.youngs_modulus, simulated.beds[0], RmsMotion(*np.sqrt(squares))
            given = self.settings.youngs_modulus
            moduli.append(softened(*particle, given) if given else softest(*particle))
        return moduli
