"""A panel on moving supports against the modal series of a simply supported plate and limits."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from moving import (
    APPARENT,
    DAMPING,
    MASS,
    MASS_PER_AREA,
    POINT_MASS,
    POINTS,
    RATIO,
    SIZE,
    STIFFNESS,
    solved,
)

from pidpanel.solve.base_motion import TABLE_MASS, inertia_of


def table_frequency(m, n):
    """Natural frequencies of the plate [Hz]."""
    k = np.pi**2 * ((m / SIZE[0]) ** 2 + (n / SIZE[1]) ** 2)
    return np.sqrt(STIFFNESS / MASS_PER_AREA) * k / (2 * np.pi)


def navier(frequency, highest=400):
    """Ratios of accelerations at the points and of force to mass times acceleration, by Navier."""
    m, n = (k.ravel() for k in np.meshgrid(*2 * [np.arange(1, highest, 2)], indexing="ij"))
    own = 2 * np.pi * table_frequency(m, n)
    omega = 2 * np.pi * frequency[:, None]
    gain = omega**2 / (own**2 - omega**2 + 2j * RATIO * own * omega)
    at = np.array(
        [
            np.sin(m * np.pi * x / SIZE[0]) * np.sin(n * np.pi * y / SIZE[1])
            for x, y in POINTS.values()
        ]
    )
    part = 16 / (np.pi**2 * m * n)
    return 1 + gain @ (part * at).T, 1 + gain @ (part**2 / 4)


def test_a_simply_supported_plate_moves_as_its_modal_series(panel):
    frequency = np.array([5.0, 40.0, 64.9, 66.0, 100.0, 180.0, 224.7, 300.0, 395.0])
    points, force = navier(frequency)
    motion, pull, _ = solved(panel, frequency)
    ratio = -((2 * np.pi * frequency[:, None]) ** 2) * motion[:, :-1, 0]
    # (1, 3) at 424 Hz is 0.05 % stiff, which the line at 395 Hz shows 15 times as large
    highest = np.abs(points).max(axis=1)[:, None]
    np.testing.assert_allclose(ratio / highest, points / highest, atol=1e-2)
    np.testing.assert_allclose(pull / MASS, force, rtol=1e-2)


def test_the_translation_moves_all_points_alike_and_bends_nothing(panel):
    basis = panel.basis
    for name in ("shape_at_points", "shape_at_quadrature", "shape_at_vertices"):
        np.testing.assert_array_equal(getattr(basis, name)[..., -1], 1)
    for name in ("curvature", "shear"):
        for place in ("points", "vertices"):
            np.testing.assert_array_equal(getattr(basis, f"{name}_at_{place}")[..., -1], 0)
    # two motions of each of two points; the momentum of the interface and the integral of one patch
    assert panel.observed.shape == (3, 2, panel.modal.natural_frequency.size)
    # what it has in common with the other shapes are their integrals over patch and face
    weight, shape = basis.quadrature_weight, basis.shape_at_quadrature
    np.testing.assert_allclose(basis.face_overlap[-1], weight @ shape, rtol=1e-6, atol=1e-9)
    np.testing.assert_allclose(basis.patch_overlap[0, -1], panel.observed[-1, 1], rtol=1e-9)


def test_the_integrals_over_all_patches_come_before_that_of_the_face(panel):
    # the patch and the rest of the face
    basis, whole = panel.supported.basis, panel.supported.basis.cell_in_patch[0]
    two = replace(basis, cell_in_patch=np.array([whole, ~whole]))
    inertia = inertia_of(two, panel.plate, panel.supported.vectors, MASS)
    of_panel = panel.inertia
    np.testing.assert_allclose(inertia.patch_integral[0], of_panel.patch_integral[0])
    # those of antisymmetric shapes are 0 to rounding
    close = partial(np.testing.assert_allclose, atol=1e-12)
    close(inertia.patch_integral.sum(axis=0), of_panel.face_integral)
    close(inertia.face_integral, of_panel.face_integral)


def test_at_rest_all_moves_with_the_supports(loaded_panel):
    frequency = np.array([0.02, 0.05])
    motion, force, _ = solved(loaded_panel, frequency, 0.0, APPARENT)
    ratio = -((2 * np.pi * frequency[:, None]) ** 2) * motion[:, :-1, 0]
    np.testing.assert_allclose(np.abs(ratio), 1, rtol=3e-6)
    np.testing.assert_allclose(motion[:, :-1, 1] / motion[:, :-1, 0], 0, atol=3e-4)
    np.testing.assert_allclose(force, MASS + POINT_MASS + APPARENT * 0.08, rtol=3e-6)


def test_effective_masses_sum_to_the_mass(panel, loaded_panel):
    basis, inertia = panel.supported.basis, panel.inertia
    effective = inertia.effective_mass(basis.modal_mass)
    modes = effective[~basis.is_residual]
    exact = 64 / np.pi**4 * MASS / np.array([1.0, 9.0])  # of (1, 1) and (3, 1)
    np.testing.assert_allclose(np.sort(modes)[::-1][:2], exact, rtol=2e-4)
    m, n = np.meshgrid(*2 * [np.arange(1, 20, 2)])
    below = panel.supported.basis.natural_frequency[~basis.is_residual].max()
    series = (64 / np.pi**4 * MASS / (m * n) ** 2)[table_frequency(m, n) <= below * 1.001]
    assert modes.sum() == pytest.approx(series.sum(), rel=2e-4)
    # all modes of all elements: what is missing is the mass of the elements at the supports
    for part in (panel, loaded_panel):
        total = part.plate.inertia @ spla.spsolve(part.plate.mass.tocsc(), part.plate.inertia)
        assert 0.97 * part.inertia.mass < total < part.inertia.mass
    assert loaded_panel.inertia.mass == pytest.approx(MASS + POINT_MASS)


def test_dampers_pull_at_the_absolute_motion_and_take_what_the_shaker_gives(panel):
    frequency = np.array([30.0, 65.0, 130.0, 224.0, 390.0])
    motion, force, _ = solved(panel, frequency, DAMPING, APPARENT)
    n = panel.modal.natural_frequency.size - 1
    modal, D = panel.modal, panel.basis.patch_overlap[0]
    L = panel.inertia.participation
    for line, f in enumerate(frequency):
        omega, s = 2 * np.pi * f, 1j * 2 * np.pi * f * DAMPING - (2 * np.pi * f) ** 2 * APPARENT
        z = -1 / omega**2  # of a unit acceleration
        stiffness = np.diag(modal.dynamic_stiffness(np.array([f]))[0, :n]) + s * D[:n, :n]
        q = np.linalg.solve(stiffness, omega**2 * L * z - s * D[:n, n] * z)
        all_shapes = np.append(q, z)
        np.testing.assert_allclose(
            motion[line], panel.observed @ all_shapes, rtol=1e-6, atol=1e-9 * abs(z)
        )
        power = 0.5 * np.real(force[line] * np.conj(1 / (1j * omega)))
        lost = 0.5 * omega**2 * (modal.damping[:n] @ np.abs(q) ** 2)
        lost += 0.5 * omega**2 * DAMPING * np.real(all_shapes.conj() @ D @ all_shapes)
        assert power == pytest.approx(lost, rel=1e-6)
    assert TABLE_MASS >= 1e8
