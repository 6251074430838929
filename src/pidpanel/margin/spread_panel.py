"""The panel over the spread of its inputs: its shapes, sound, air and patches, ready for runs."""

from __future__ import annotations

import tempfile
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping_ratio import DampingRatio
from pidpanel.geometry.polygon import Rectangle
from pidpanel.margin.family import PanelFamily, Parts, compressed, with_static_rest
from pidpanel.panel.basis import (
    PanelBasis,
    basis_of,
    face_wavenumber,
    patch_areas,
    with_condensed_face,
)
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.panel.modes import normal_modes, normalise
from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.shapes import LEAST_MODES, MODES_BEYOND, Shapes, panel_shapes
from pidpanel.solve.model import ModalBasis

SHIFTS = 4  # positions of a patch along each direction between which its shapes are interpolated
PATCH_POINTS = 14  # of the quadrature of a patch along each side
# Frequency over the highest up to which the family has modes, and a run keeps them. With
# `RESIDUAL` and `family.ENERGY`, g rms of the paper's panel is within 3e-4, bare and with dampers.
SHAPES_TO, MODES_TO = 1.2, 1.2
RESIDUAL = 1e-2  # tolerance of `panel.shapes.residual_vectors`
RIGID = 1e-3  # frequency over the highest below which a mode moves rigidly


def parameters(panel: StudiedPanel) -> tuple[list[float], list[float]]:
    """Return what enters K and M of a panel linearly."""
    section, springs = panel.section, panel.supports
    shear = np.asarray(getattr(section, "shear", np.zeros((2, 2))))
    stiffness = [*section.bending.ravel().tolist(), *shear.ravel().tolist(), springs.stiffness]
    stiffness += [edge.stiffness for edge in springs.edges]
    mass = [section.mass_per_area, getattr(section, "rotary_inertia", 0.0)]
    for attached in panel.attachments.values():
        stiffness.append(attached.stiffness or 0.0)
        mass.append(attached.mass or 0.0)
    return stiffness, mass


class SpreadPanel:
    """A panel over the spread of its inputs.

    Parameters
    ----------
    panels
        All panels: the nominal one first, then those at the ends of spreads, then samples.
    ends
        Number of the first ones whose shapes the family has.
    highest
        Highest frequency of the responses [Hz].
    heavy
        Heaviest damper of each patch by name [kg/m²].
    sound
        Largest wavenumber of the sound [rad/m].
    """

    def __init__(
        self,
        panels: Sequence[StudiedPanel],
        ends: int,
        highest: float,
        heavy: Mapping[str, float],
        sound: float,
    ) -> None:
        self.highest = highest
        rows = [np.array(part) for part in zip(*map(parameters, panels), strict=True)]
        self.stiffness, self.mass = map(Parts.spanning, rows)
        with tempfile.TemporaryDirectory() as folder:
            sizes = panels[0].patch_sizes(highest, heavy)
            mesh = panels[0].mesh(Path(folder) / "mesh.msh", sizes)
        needed = sorted({0, *self.stiffness.chosen.tolist(), *self.mass.chosen.tolist()})
        plates = {number: panels[number].plate(mesh) for number in needed}
        plate = plates[0]
        stiffness = [plates[n].stiffness for n in self.stiffness.chosen.tolist()]
        mass = [plates[n].mass for n in self.mass.chosen.tolist()]

        def plate_of(number: int) -> AssembledPlate:
            K, M = (
                sum(float(c) * part for c, part in zip(parts.share[number], matrices, strict=True))
                for parts, matrices in ((self.stiffness, stiffness), (self.mass, mass))
            )
            return replace(plate, stiffness=K, mass=M)

        nominal = panel_shapes(plate, SHAPES_TO * highest, RESIDUAL, damper_mass=heavy)
        shapes = [nominal.vectors]
        for number in self.stiffness.distinct(np.arange(ends))[1:].tolist():
            shapes.append(normal_modes(plate_of(number), SHAPES_TO * highest, LEAST_MODES)[1])
        V = normalise(plate, compressed(shapes, plate.stiffness, plate.mass, highest))
        self.family = PanelFamily(
            np.array([V.T @ (K @ V) for K in stiffness]), np.array([V.T @ (M @ V) for M in mass])
        )
        count = len(nominal.frequency)
        basis = basis_of(mesh, plate, Shapes(np.zeros(count), np.zeros(V.shape[1] - count), V))
        self.basis: PanelBasis = with_condensed_face(basis, face_wavenumber(basis, sound))
        self.area = patch_areas(basis)
        self._rows = [_patch_rows(name, panels, plate, V) for name in basis.patch_names]

    def patch_rows(self, panel: StudiedPanel) -> Array:
        """Return rows (n_patches, k, n) of the patches of a panel, padded with zeros."""
        parts = []
        for name, (x, y, rows) in zip(self.basis.patch_names, self._rows, strict=True):
            centre = _centre(panel, name)
            shares = np.outer(_lagrange(x, centre[0]), _lagrange(y, centre[1]))
            parts.append(np.tensordot(shares, rows, axes=2))
        longest = max((len(part) for part in parts), default=0)
        padded = [np.pad(part, ((0, longest - len(part)), (0, 0))) for part in parts]
        return np.array(padded).reshape(len(parts), longest, -1)

    def modes(
        self, number: int, panel: StudiedPanel, ratio: DampingRatio
    ) -> tuple[ModalBasis, Array]:
        """Return modes of 1 kg of a panel, and their vectors (n, m), with ζ of the bare panel."""
        natural, vectors = self.family.modes(self.stiffness.share[number], self.mass.share[number])
        rows = list(self.patch_rows(panel))
        loads = [*rows, self.basis.shape_at_points]
        natural, vectors = with_static_rest(natural, vectors, loads, MODES_TO * self.highest)
        natural[natural < RIGID * self.highest] = 0.0
        cutoff = MODES_BEYOND * self.highest
        damping = ratio.ratio_at(cutoff) * natural / cutoff  # see `basis_error.modal_basis`
        of_modes = natural <= cutoff
        damping[of_modes] = ratio.of_modes(natural[of_modes])
        return ModalBasis(natural, np.ones(natural.size), damping), vectors


def _patch_rows(
    name: str, panels: Sequence[StudiedPanel], plate: AssembledPlate, V: Array
) -> tuple[Array, Array, Array]:
    """Return nodes of the centre along x and y (SHIFTS,) and rows (SHIFTS, SHIFTS, k, n)."""
    centres = np.array([_centre(panel, name) for panel in panels])
    shape = panels[0].shapes.get(name)
    if not isinstance(shape, Rectangle) or not np.ptp(centres, axis=0).any():
        members = plate.patch_overlap[name]
        value, vector = np.linalg.eigh(V.T @ (members @ V))
        large = value > 1e-14 * value[-1]
        fixed = (vector[:, large] * np.sqrt(value[large])).T
        return np.zeros(1), np.zeros(1), fixed[None, None]
    node, weight = np.polynomial.legendre.leggauss(PATCH_POINTS)
    size = np.ptp(shape.corners, axis=0)
    local = np.stack(np.meshgrid(*(node * side / 2 for side in size)), axis=-1).reshape(-1, 2)
    root = np.sqrt(np.outer(weight, weight).ravel() * np.prod(size) / 4)[:, None]
    ends = zip(centres.min(axis=0), centres.max(axis=0), strict=True)
    x, y = (np.linspace(low, high, SHIFTS if low < high else 1) for low, high in ends)
    centre = np.stack(np.meshgrid(x, y, indexing="ij"), axis=-1)
    rows = [[root * (plate.interpolate(local + place) @ V) for place in line] for line in centre]
    return x, y, np.array(rows)


def _centre(panel: StudiedPanel, name: str) -> tuple[float, float]:
    """Return the centre of a rectangle [m]; other patches do not shift."""
    shape = panel.shapes.get(name)
    return shape.centre if isinstance(shape, Rectangle) else (0.0, 0.0)


def _lagrange(node: Array, x: float) -> Array:
    """Return the polynomials of nodes at x."""
    distance = node[:, None] - node + np.eye(node.size)
    factors = np.where(np.eye(node.size, dtype=bool), 1.0, (x - node) / distance)
    return np.asarray(factors.prod(axis=1))
