"""The panel of a study under its excitation, with the patches of a scenario."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from scipy.linalg import eigh

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupled.coupled_panel import CoupledPanel, CoupledPatch, bare_psd
from pidpanel.coupled.scenario import CoupledScenario, RunSettings
from pidpanel.coupled.softening import RmsMotion, Softened, softened_modulus, softening_bias
from pidpanel.damping.models import FilledDamper
from pidpanel.panel.basis import PanelBasis, patch_areas
from pidpanel.panel.matrices import StoredPlate
from pidpanel.solve.base_motion import BaseExcitation
from pidpanel.solve.basis_error import modal_basis
from pidpanel.solve.excitation import Excitation, ModalForce
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.panel import deflection_at_points
from pidpanel.solve.source import PatchParts
from pidpanel.sound.radiation import Air

AIR_NODES = 25  # frequencies at which the air is evaluated


class LinearDamper(NamedTuple):
    """A damper with given C_e and m_a on a patch."""

    overlap: Array  # (n, n) D of its patch [m²]
    # C_e [N s/m³] and m_a [kg/m²] at frequencies (k,) [Hz]
    values: Callable[[Array], tuple[Array, Array]]


@dataclass(frozen=True)
class LoadedShapes:
    """Oscillators, and their shapes in those of the bare panel."""

    modal: ModalBasis
    # (n, n) new shapes as columns; None where they are those of the bare panel
    vectors: Array | None
    # dynamic stiffness (nf, n) [N/m] with the air of each frequency (nf,) [Hz]; None without air
    in_air: Callable[[Array], Complexes] | None = None

    def gain(self, frequency: Array, force: Array) -> Callable[[Array], Array]:
        """Return the PSD of forces that moves the oscillators as in air, over that of the sound.

        It is a factor for each third octave, of lines (nf,) [Hz] and PSDs (nf, n) of forces.
        """
        if self.in_air is None:
            return np.ones_like
        low, high = frequency[0], frequency[-1]
        count = max(1, round(3 * np.log2(high / low)))
        edge = np.geomspace(low, high, count + 1)

        def acceleration(stiffness: Complexes) -> Array:
            psd = frequency**4 * (force / np.abs(stiffness) ** 2).sum(axis=1)
            area = np.diff(frequency) * (psd[1:] + psd[:-1]) / 2
            square = np.interp(edge, frequency, np.append(0.0, np.cumsum(area)))
            return np.asarray(np.diff(square))

        wanted = acceleration(self.in_air(frequency))
        factor = wanted / acceleration(self.modal.dynamic_stiffness(frequency))

        def at(lines: Array) -> Array:
            return np.asarray(factor[np.searchsorted(edge[1:-1], lines, side="right")])

        return at

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
    air: Callable[[Array], Complexes] | None,
    dampers: Sequence[LinearDamper],
) -> LoadedShapes:
    """Return the oscillators of a panel in air with dampers that are not integrated.

    The panel moves in shapes of its own, each a single oscillator: those of its mass with m_a D of
    dampers and the air's, both a mean over the logarithm of frequency. Each then has the mass of
    the air, its resistance and C_e D at its own frequency, without what couples it to others. The
    air of other frequencies enters the level of the force (`LoadedShapes.gain`). What is left out
    changes the motion in which the particles are seen a little, and C_e and m_a hardly; the
    response is computed with all of it (`pidpanel.response`).
    """
    if air is None and not dampers:
        return LoadedShapes(modal, None)
    nodes = np.geomspace(*extent, AIR_NODES)
    n = len(modal.modal_mass)
    added = np.zeros((AIR_NODES, n, n))  # mass and resistance of the air at the nodes
    resistance = np.zeros_like(added)
    if air is not None:
        for index, frequency in enumerate(nodes):
            stiffness, omega = air(nodes[index : index + 1])[0], 2 * np.pi * frequency
            added[index], resistance[index] = -stiffness.real / omega**2, stiffness.imag / omega
    mean_added = added.mean(axis=0)
    bare = np.diag(modal.modal_mass)
    heavy = bare + mean_added + sum(d.values(nodes)[1].mean() * d.overlap for d in dampers)
    square, vectors = eigh(np.diag(modal.modal_mass * modal.angular_frequency**2), heavy)
    natural = np.sqrt(np.maximum(square, 0)) / (2 * np.pi)
    clipped = np.clip(natural, *extent)

    def diagonal(matrix: Array) -> Array:
        return np.einsum("in,...ij,jn->...n", vectors, matrix, vectors, optimize=True)

    def at_modes(values: Array) -> Array:
        pairs = zip(np.log(clipped), values.T, strict=True)
        return np.array([np.interp(place, np.log(nodes), row) for place, row in pairs])

    more, lost = diagonal(added - mean_added), diagonal(resistance)
    own_more, own_lost = at_modes(more), at_modes(lost)
    mass = 1 + own_more
    damping = diagonal(np.diag(modal.damping)) + own_lost
    for damper in dampers:
        damping = damping + damper.values(clipped)[0] * diagonal(damper.overlap)
    oscillators = _oscillators(natural / np.sqrt(mass), mass, damping)

    def in_air(frequency: Array) -> Complexes:
        order = np.interp(np.log(frequency), np.log(nodes), np.arange(AIR_NODES))
        start = np.minimum(order.astype(int), AIR_NODES - 2)
        part = (order - start)[:, None]
        mass, loss = (v[start] + part * (v[start + 1] - v[start]) for v in (more, lost))
        omega, own = 2 * np.pi * frequency[:, None], oscillators.dynamic_stiffness(frequency)
        return np.asarray(own - omega**2 * (mass - own_more) + 1j * omega * (loss - own_lost))

    return LoadedShapes(oscillators, vectors, None if air is None else in_air)


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
    order = np.lexsort((along[:, 1 - axis], along[:, axis]))
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
        return float(np.hypot(*np.ptp(self.basis.vertex_position, axis=0)))

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
            translation = np.ones((len(values), len(self.modal.modal_mass) - values.shape[1]))
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

    def shapes(self, scenario: CoupledScenario) -> LoadedShapes:
        """Return the shapes of the panel with what of a scenario is not integrated."""
        dampers = [self._linear(*item, scenario.factor) for item in scenario.dampers.items()]
        return loaded_shapes(self.modal, self.settings.frequency_range, self.air, dampers)

    def _linear(self, patch: str, damper: FilledDamper, factor: float) -> LinearDamper:
        """Return C_e and m_a of a damper at the motion of the bare patch."""
        index = self.basis.patch_names.index(patch)
        overlap, area = self.basis.patch_overlap[index], patch_areas(self.basis)[index]
        square, vector = np.linalg.eigh(overlap)  # D = E Eᵀ
        frequency, columns = self.coarse_frequency, vector * np.sqrt(np.maximum(square, 0.0))
        psd = bare_psd(self.modal, self.excitation, columns.T, frequency).sum(axis=1) / area
        mean_square = np.trapezoid((2 * np.pi * frequency) ** 4 * psd, frequency)
        gamma = float(np.sqrt(2 * factor * mean_square)) / STANDARD_GRAVITY

        return LinearDamper(overlap, lambda frequency: damper.damping(frequency, gamma)[:2])

    def with_patches(self, scenario: CoupledScenario) -> CoupledPanel:
        """Return the panel with the patches of a scenario, at its level."""
        shapes, excitation = self.shapes(scenario), self.excitation
        gain = self._gain(shapes)
        return CoupledPanel(
            modal=shapes.modal,
            points=shapes.shape(deflection_at_points(self.basis)),
            patches=[
                self.patch(patch.name, patch.beds[0].packing.cell_area, shapes)
                for patch in scenario.patches
            ],
            excitation=ModalForce(
                lambda frequency: (
                    scenario.factor * gain(frequency) * excitation.spectrum(frequency)
                ),
                lambda frequency: shapes.square(excitation(frequency)),
                # of base motion G is not resolved: the force on the table is 1e8 times the others
                (lambda frequency: shapes.columns(excitation.factors(frequency)))
                if isinstance(excitation, BaseExcitation)
                else None,
            ),
        )

    def _gain(self, shapes: LoadedShapes) -> Callable[[Array], Array]:
        frequency, span = self.coarse_frequency, self.settings.frequency_range
        if shapes.in_air is None:
            return np.ones_like
        nodes = np.geomspace(*span, AIR_NODES)
        force = np.array(
            [
                np.diagonal(shapes.square(self.excitation(f)[0])).real
                for f in np.split(nodes, AIR_NODES)
            ]
        )
        rows = np.array([np.interp(np.log(frequency), np.log(nodes), row) for row in force.T]).T
        return shapes.gain(frequency, rows * self.excitation.spectrum(frequency)[:, None])

    def moduli(self, scenario: CoupledScenario, panel: CoupledPanel) -> list[Softened]:
        """Return Young's modulus of the contacts of each patch [Pa], and its bias of g rms [1]."""
        frequency, omega = self.coarse_frequency, 2 * np.pi * self.coarse_frequency
        moduli = []
        for simulated, patch in zip(scenario.patches, panel.patches, strict=True):
            psds = bare_psd(panel.modal, panel.excitation, patch.shape, frequency)
            psd = psds @ patch.area / patch.area.sum()
            squares = [float(np.trapezoid(omega**k * psd, frequency)) for k in (2, 4)]
            particle = simulated.youngs_modulus, simulated.beds[0], RmsMotion(*np.sqrt(squares))
            modulus = self.settings.youngs_modulus or softened_modulus(*particle)
            moduli.append(Softened(modulus, softening_bias(*particle, modulus)))
        return moduli
