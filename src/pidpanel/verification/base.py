"""Base motion compared with closed forms: an oscillator, a simply supported plate, its limits."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import scipy.sparse.linalg as spla

from pidpanel.arrays import Array, Complexes
from pidpanel.base.sine import Transfer, interface_force
from pidpanel.damping_ratio import DampingRatio
from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.basis import basis_of, with_condensed_face
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import panel_shapes
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.solve.base_motion import (
    TABLE_MASS,
    BaseExcitation,
    observed_motions,
    supported_panel,
    with_translation,
)
from pidpanel.solve.basis_error import modal_basis
from pidpanel.solve.layout import DamperLayout, layouts
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis, Patches, UnstableDamping
from pidpanel.solve.panel import ModalPanel
from pidpanel.solve.receptances import patch_stiffness
from pidpanel.verification.rows import Row, cases_of, comparison

SIZE, RIGIDITY, MASS_PER_AREA, RATIO = (1.5, 1.0), 3273.07, 4.0, 0.02
MASS = MASS_PER_AREA * SIZE[0] * SIZE[1]
HIGHEST = 400.0
PATCH_AREA = 0.4 * 0.2
DAMPING, APPARENT = 600.0, 3.0  # C_e [N s/m³] and m_a [kg/m²] of the damper

POINTS = {"(0.75, 0.5)": (0.75, 0.5), "(0.3, 0.3)": (0.3, 0.3)}  # [m]

ELEMENTS = (30, 20)
METHOD = f"{ELEMENTS[0]} × {ELEMENTS[1]} elements"


def oscillator_rows(_: Path) -> Iterator[Row]:
    """Compute an oscillator of 50 Hz, ζ = 5 %, under white base acceleration, 2 (m/s²)²/Hz."""
    natural, ratio, mass, level = 50.0, 0.05, 3.0, 2.0
    basis = ModalBasis([natural, 0.0], [mass, TABLE_MASS * mass], [ratio, ratio])
    motions = np.array([[[1.0, 1.0], [1.0, 0.0]]])  # absolute and relative
    force = np.array([-mass, TABLE_MASS * mass])
    excitation = BaseExcitation(lambda f: np.full(f.shape, level), force)

    def psds(frequency: Array) -> Array:
        panel = ModalPanel(basis, Patches(np.zeros((0, 2, 2)), []), frequency, motions, frequency)
        (answer,) = layouts(panel, excitation, [DamperLayout(())])
        if isinstance(answer, UnstableDamping):
            raise answer
        cross = np.einsum("fii->fi", answer.response.cross_psd[:, 0]).real
        return np.asarray((2 * np.pi * frequency[:, None]) ** 4 * cross)

    at_lines = comparison("oscillator")
    for frequency in (20.0, 50.0, 120.0):
        r = frequency / natural
        denominator = (1 - r**2) ** 2 + (2 * ratio * r) ** 2
        closed = level * np.array([1 + (2 * ratio * r) ** 2, r**4]) / denominator
        for name, value, exact in zip(
            ("absolute", "relative"), psds(np.array([frequency]))[0], closed, strict=True
        ):
            quantity = f"{name} acceleration PSD at {frequency:g} Hz"
            yield at_lines.row(quantity, value, exact, frequency)
    lines = frequency_grid(2e-4, 1e7, ratio)
    rms = np.sqrt(np.trapezoid(psds(lines)[:, 0], lines))
    miles = np.sqrt(level * np.pi * natural * (1 + 4 * ratio**2) / (4 * ratio))
    yield comparison("oscillator_rms").row("rms of the absolute acceleration", rms, miles)


class _Plate:
    """The simply supported plate of the paper, 30 × 20 elements, with one patch."""

    def __init__(self, folder: Path) -> None:
        patch = {"patch": Rectangle((0.7, 0.5), (0.4, 0.2))}
        mesh = mesh_quadrilaterals(folder / "plate.msh", SIZE, ELEMENTS, patch, POINTS)
        plate = assemble_thin_plate(mesh, ThinSection(RIGIDITY, MASS_PER_AREA))
        shapes = panel_shapes(plate, 2 * HIGHEST)
        basis = with_condensed_face(basis_of(mesh, plate, shapes), 40.0)
        empty = np.zeros((shapes.vectors.shape[0], 0))
        self.mass, self.inertia = plate.mass, plate.inertia
        stored = plate.with_shapes(shapes.vectors)
        self.supported = supported_panel(basis, stored, empty, HIGHEST, MASS)
        inertia = self.supported.inertia
        self.basis = with_translation(self.supported.basis, inertia)
        self.modal = modal_basis(self.basis, DampingRatio((RATIO,)), HIGHEST)
        self.force = BaseExcitation.of_inertia(np.ones_like, inertia).force

    def solve(
        self, frequency: Array, damping: float = 0.0, mass: float = 0.0
    ) -> tuple[Complexes, Complexes, Complexes]:
        """Return transmissibilities (nf, 2), forces [kg], shapes (nf, n + 1) per acceleration."""
        patches, count = Patches(self.basis.patch_overlap, [PATCH_AREA]), len(self.force)
        motions = observed_motions(self.basis, self.supported.inertia).reshape(-1, count)
        observed = np.concatenate([motions, np.eye(count)])
        transfer = Transfer.of_panel(frequency, self.modal, patches, self.force, observed)
        s = patch_stiffness(frequency, *np.full((2, 1, frequency.size), [[[damping]], [[mass]]]))
        motion = transfer.motions(s)
        shapes = motion[:, -count:]
        points = motion[:, : len(motions)].reshape(len(frequency), 3, -1)
        absolute = -((2 * np.pi * frequency[:, None]) ** 2) * points[:, :-1, 0]
        return absolute, interface_force(frequency, points[:, -1], [0], s), shapes


def _navier(frequency: Array, points: Array, highest: int = 400) -> tuple[Complexes, Complexes]:
    """Return transmissibilities (nf, n_points) and force over mass (nf,) by 40 000 modes."""
    m, n = (k.ravel() for k in np.meshgrid(*2 * [np.arange(1, highest, 2)], indexing="ij"))
    wavenumber = np.pi**2 * ((m / SIZE[0]) ** 2 + (n / SIZE[1]) ** 2)
    natural, omega = np.sqrt(RIGIDITY / MASS_PER_AREA) * wavenumber, 2 * np.pi * frequency[:, None]
    gain = omega**2 / (natural**2 - omega**2 + 2j * RATIO * natural * omega)
    product = np.prod(
        np.sin(np.pi * np.stack([m, n]) * points[:, :, None] / np.array(SIZE)[:, None]), axis=1
    )
    part = 16 / (np.pi**2 * m * n)
    return 1 + gain @ (product * part).T, 1 + gain @ (64 / (np.pi**4 * m**2 * n**2))


def supported_plate_rows(folder: Path) -> Iterator[Row]:
    """Compute the simply supported plate of the paper, ζ = 2 %, against its modal series."""
    plate = _Plate(folder)
    frequency = np.array([40.0, 64.9, 180.0, 224.7])
    gain, force, _ = plate.solve(frequency)
    exact, whole = _navier(frequency, np.array(list(POINTS.values())))
    ratio = comparison("plate", elements=METHOD)
    weight = replace(ratio, unit="kg")
    for line, f in enumerate(frequency.tolist()):
        for name, value, reference in zip(POINTS, abs(gain[line]), abs(exact[line]), strict=True):
            yield ratio.row(f"transmissibility at {name}, {f:g} Hz", value, reference, f)
        value, reference = abs(force[line]), abs(MASS * whole[line])
        yield weight.row(f"force over acceleration, {f:g} Hz", value, reference, f)


def limits_rows(folder: Path) -> Iterator[Row]:
    """Compute limits for any panel on a moving base: near 0 Hz, and for all its modes."""
    plate = _Plate(folder)
    gain, force, _ = plate.solve(np.array([0.02]), 0.0, APPARENT)
    rigid, weight, modal_weight, full = (
        comparison(name, elements=METHOD)
        for name in ("rigid_motion", "rigid_force", "effective_mass", "whole_mass")
    )
    supported = plate.supported
    effective = supported.inertia.effective_mass(supported.basis.modal_mass)
    m, n = np.meshgrid(*2 * [np.arange(1, 40, 2)])
    natural = (
        np.sqrt(RIGIDITY / MASS_PER_AREA) * np.pi / 2 * ((m / SIZE[0]) ** 2 + (n / SIZE[1]) ** 2)
    )
    modes = ~supported.basis.is_residual
    is_resolved = natural < 1.001 * supported.basis.natural_frequency[modes].max()
    series = 64 / np.pi**4 * MASS / (m * n) ** 2.0
    carried = MASS + APPARENT * PATCH_AREA
    quantity = f"sum of the effective masses of the modes to {2 * HIGHEST:g} Hz"
    all_modes = plate.inertia @ spla.spsolve(plate.mass.tocsc(), plate.inertia)
    for name, value in zip(POINTS, gain[0], strict=True):
        yield rigid.row(f"transmissibility at {name}, 0.02 Hz", abs(value), 1.0)
    yield weight.row("force over acceleration, 0.02 Hz, with particles", abs(force[0]), carried)
    yield modal_weight.row(quantity, effective[modes].sum(), series[is_resolved].sum())
    yield full.row("sum of the effective masses of all elements", all_modes, MASS)


def balance_rows(folder: Path) -> Iterator[Row]:
    """Compute the power of the shaker against the losses in the structure and in a damper."""
    plate = _Plate(folder)
    frequency = np.array([30.0, 65.0, 224.0, 390.0])
    _, force, shapes = plate.solve(frequency, DAMPING, APPARENT)
    overlap, count = plate.basis.patch_overlap[0], len(plate.force) - 1
    balance = comparison("power_of_shaker", elements=METHOD)
    for line, f in enumerate(frequency.tolist()):
        omega, q = 2 * np.pi * f, shapes[line]
        power = 0.5 * float(np.real(force[line] * np.conj(1 / (1j * omega))))
        lost = 0.5 * omega**2 * float(plate.modal.damping[:count] @ np.abs(q[:count]) ** 2)
        lost += 0.5 * omega**2 * DAMPING * float(np.real(q.conj() @ overlap @ q))
        quantity = f"power of the shaker per acceleration squared, {f:g} Hz"
        yield balance.row(quantity, power, lost, f)


CASES = cases_of(globals())
