"""The paper's panel in its elements and in the shapes of a study, for verification."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from functools import partial
from pathlib import Path

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as spla

from pidpanel.arrays import Array
from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.basis import PanelBasis, basis_of, patch_areas
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.plate import AssembledPlate
from pidpanel.panel.plate_files import StoredPlate
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import panel_shapes
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.response.refinement import ATTEMPTS
from pidpanel.solve.basis_error import (
    MovedFace,
    PatchDampers,
    basis_shapes,
    check_basis,
    cutoff_frequency,
    damping_ratios,
    lines_to_try,
)
from pidpanel.solve.dampers import attach_dampers
from pidpanel.solve.modal import bare_panels
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.sound.face import PanelQuadrature
from pidpanel.sound.field import diffuse_modal_force, wavenumber

SPEED = 343.0
SIZE, ELEMENTS = (1.5, 1.0), (30, 20)
SECTION = ThinSection(3273.07, 4.0)
POINTS = {"in the middle": (0.75, 0.5), "beside it": (0.35, 0.5), "near an edge": (0.10, 0.30)}

TRUNCATION = 5e-3
"""Largest error of a PSD that a basis may leave, as the documents say."""

RAYLEIGH = (4.0, 6e-6)
"""α [1/s] and β [s] of C = αM + βK: a damping that sparse matrices can have too."""

HIGHEST = 1000.0
LINES = (60.0, 300.0, 600.0, 850.0, 951.0, HIGHEST)
"""Lines [Hz] at which shapes stand beside all elements."""


@dataclass(frozen=True)
class Studied:
    """A panel in its elements and in the shapes of a study.

    Attributes
    ----------
    plate
        In elements, where it stands beside them.
    ratio
        (n,) damping ratio of the shapes.
    """

    plate: AssembledPlate | None
    basis: PanelBasis
    ratio: Array

    @classmethod
    def rayleigh(cls, plate: AssembledPlate | None, basis: PanelBasis) -> "Studied":
        """Return the panel with the damping that both can have."""
        omega = 2 * np.pi * basis.natural_frequency
        return cls(plate, basis, RAYLEIGH[0] / (2 * omega) + RAYLEIGH[1] * omega / 2)

    @property
    def modal(self) -> ModalBasis:
        """Frequencies, masses and damping of the shapes."""
        return ModalBasis(self.basis.natural_frequency, self.basis.modal_mass, self.ratio)

    def patches(self, names: Sequence[str]) -> Patches:
        """Return some of its patches."""
        index = [self.basis.patch_names.index(name) for name in names]
        return Patches(self.basis.patch_overlap[index], patch_areas(self.basis)[index])

    def force(self, frequency: Array) -> Array:
        """Return G (nf, n, n) of a diffuse field [m⁴]."""
        basis = self.basis
        face = PanelQuadrature(
            basis.quadrature_position, basis.quadrature_weight, basis.shape_at_quadrature
        )
        return np.stack([diffuse_modal_force(float(k), face) for k in wavenumber(frequency, SPEED)])

    def psd(self, frequency: Array, force: Array, dampers: Mapping[str, "Damper"]) -> Array:
        """Return the displacement PSD at the points per S_p, (nf, n_points) [m²/Pa²]."""
        (bare,) = bare_panels(
            frequency, self.modal, [self.patches(list(dampers))], self.basis.shape_at_points,
            np.ones(frequency.size), force,
        )  # fmt: skip
        flat = np.ones(frequency.size)
        damping, mass = (
            np.array([value * flat for value in values]).reshape(-1, frequency.size)
            for values in (
                [one.damping for one in dampers.values()],
                [one.mass for one in dampers.values()],
            )
        )
        return attach_dampers(bare, damping, mass).displacement_psd

    def psd_of_elements(self, frequency: float, dampers: Mapping[str, "Damper"]) -> Array:
        """Return the displacement PSD at the points from the whole elements, (n_points,) [m²/Pa²].

        One sparse solve a point: with Z symmetric, w at a point under the load F of a plane wave
        is (Z⁻¹ c)ᵀF. The diffuse field is the mean over its plane waves, here by Gauss in cos θ
        and even steps in azimuth.
        """
        plate, omega = self.plate, 2 * np.pi * frequency
        if plate is None:
            raise ValueError("of this panel the shapes alone are known")
        K, M = plate.stiffness, plate.mass
        Z = K - omega**2 * M + 1j * omega * (RAYLEIGH[0] * M + RAYLEIGH[1] * K)
        for name, one in dampers.items():
            Z = Z + (1j * omega * one.damping - omega**2 * one.mass) * plate.patch_overlap[name]
        pull = plate.interpolate(self.basis.point_position).toarray().T.astype(complex)
        answer = spla.splu(sp.csc_matrix(Z)).solve(pull)
        k = float(wavenumber(frequency, SPEED))
        cosine, weight = (half[30:] for half in np.polynomial.legendre.leggauss(60))
        load = plate.quadrature_weight[:, None] * (plate.at_quadrature @ answer)  # (nq, points)
        psd = np.zeros(pull.shape[1])
        for azimuth in 2 * np.pi * np.arange(90) / 90:
            along = plate.quadrature_position @ np.array([np.cos(azimuth), np.sin(azimuth)])
            wave = np.exp(1j * k * np.outer(np.sqrt(1 - cosine**2), along))
            psd += weight @ np.abs(wave @ load) ** 2 / 90
        return psd


@dataclass(frozen=True)
class Damper:
    """C_e [N s/m³] and m_a [kg/m²] on a patch."""

    damping: float
    mass: float


def papers_panel(
    folder: Path,
    patches: Mapping[str, Rectangle],
    layouts: Sequence[Mapping[str, Damper]],
    section: ThinSection = SECTION,
    limit: float = 2 * HIGHEST,
) -> Studied:
    """Return the paper's panel with some patches, in the shapes of a study to 1 kHz."""
    mesh = mesh_quadrilaterals(folder / "panel.msh", SIZE, ELEMENTS, patches, POINTS)
    plate = assemble_thin_plate(mesh, section)
    heaviest = {name: max((on[name].mass for on in layouts if name in on), default=0.0)
                for name in patches}  # fmt: skip
    shapes = panel_shapes(plate, limit, damper_mass=heaviest)
    basis = basis_of(mesh, plate, shapes)
    stored = StoredPlate(
        **{name: getattr(plate, name) for name in STORED},
        shapes=shapes.vectors,
    )
    left_out = np.zeros((len(shapes.vectors), 0))
    wider, ratio = basis, 0.01
    for attempt in range(ATTEMPTS if layouts else 0):
        cutoff = cutoff_frequency(HIGHEST)
        modal = ModalBasis(
            wider.natural_frequency, wider.modal_mass, damping_ratios(wider, ratio, cutoff)
        )
        lines = lines_to_try((28.0, HIGHEST), len(left_out), len(POINTS) * len(layouts), attempt)
        check = check_basis(
            wider, stored, basis_shapes(basis, stored, left_out).vectors, modal,
            partial(of_shapes, wider), diffuse, ratio, cutoff, lines,
            [of_patches(list(patches), on, len(lines)) for on in layouts],
        )  # fmt: skip
        if not check.missing_shapes.shape[1]:
            break
        left_out = np.hstack([left_out, check.missing_shapes])
        wider = basis_of(mesh, plate, basis_shapes(basis, stored, left_out))
    return Studied.rayleigh(plate, wider)


def diffuse(frequency: float, face: MovedFace | PanelBasis) -> Array:
    """Return G [m⁴] of a diffuse field at a frequency [Hz]."""
    panel = PanelQuadrature(
        face.quadrature_position, face.quadrature_weight, face.shape_at_quadrature
    )
    return diffuse_modal_force(float(wavenumber(frequency, SPEED)), panel)


def of_shapes(basis: PanelBasis, frequency: Array) -> Array:
    """Return that of the shapes of a basis at frequencies (nf,) [Hz], (nf, n, n)."""
    return np.array([diffuse(f, basis) for f in frequency.tolist()])


STORED = [field.name for field in fields(StoredPlate) if field.name != "shapes"]


def of_patches(names: Sequence[str], on: Mapping[str, Damper], count: int) -> PatchDampers:
    """Return the dampers of a layout on every patch at so many lines."""
    none = Damper(0.0, 0.0)
    every = [on.get(name, none) for name in names]
    flat = np.ones(count)
    return PatchDampers(
        np.array([one.damping * flat for one in every]),
        np.array([one.mass * flat for one in every]),
    )
