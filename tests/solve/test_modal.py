"""The modal solver, held to dense algebra, closed forms and the time domain."""

from dataclasses import replace
from operator import attrgetter

import numpy as np
import pytest
from solving import air_resistance

from pidpanel.solve.dampers import attach_dampers
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.modal import (
    OVERLAP_CUTOFF,
    bare_panels,
    panel_in_shapes,
    patch_motions_in_vacuum,
)
from pidpanel.solve.model import ModalBasis, Patches, ResponseError, UnstableDamping
from pidpanel.solve.motions import Motions

EXACT = 1e-14
"""Share of the eigenvalues of D that is dropped where the algebra itself is judged."""


def dense_psd(panel, lines, patches, damping, mass, resistance=None):
    """S_q by the equations as they stand, one dense inverse a line."""
    basis = panel.basis
    psd = []
    for i, f in enumerate(lines.frequency):
        omega = 2 * np.pi * f
        omega_n = 2 * np.pi * basis.natural_frequency
        stiffness = np.diag(basis.modal_mass * omega_n**2).astype(complex)
        stiffness -= omega**2 * np.diag(basis.modal_mass)
        stiffness += 1j * omega * np.diag(2 * 0.01 * basis.modal_mass * omega_n)
        for p in range(patches.area.size):
            stiffness += (1j * omega * damping[p, i] - omega**2 * mass[p, i]) * patches.overlap[p]
        if resistance is not None:
            stiffness += 1j * omega * resistance[i]
        transfer = np.linalg.inv(stiffness)
        force = lines.modal_force[i] if lines.modal_force.ndim == 3 else lines.modal_force
        psd.append(lines.spectrum[i] * transfer @ force @ transfer.conj().T)
    return np.array(psd)


def motion_of(panel, lines, patches, modal_psd):
    """PSDs of acceleration at the points and, in the mean, over the patches."""
    omega4 = (2 * np.pi * lines.frequency) ** 4
    points = np.einsum("ai,fij,aj->fa", panel.points, modal_psd, panel.points).real
    patch = np.einsum("pij,fji->fp", patches.overlap, modal_psd).real / patches.area
    return omega4[:, None] * points, omega4[:, None] * patch


def bare_of(panel, lines, patches=None, **changes):
    arguments = {
        "frequency": lines.frequency,
        "basis": panel.basis,
        "carriers": [patches or panel.patches],
        "motion_at_points": panel.points,
        "spectrum": lines.spectrum,
        "modal_force": lines.modal_force,
        "overlap_cutoff": EXACT,
    }
    (bare,) = bare_panels(**(arguments | changes))
    return bare


def one_patch(panel, index=0):
    return Patches(panel.patches.overlap[index : index + 1], panel.patches.area[index : index + 1])


@pytest.mark.parametrize("strength", [0.0, 1.0, 100.0])
def test_attaching_dampers_is_the_dense_solve(panel, lines, strength):
    # Woodbury is exact: what a pinned patch cancels costs 4e-9 at a hundred times the damper
    damping, mass = strength * lines.equivalent_damping, strength * lines.apparent_mass
    response = attach_dampers(bare_of(panel, lines), damping, mass)
    points, _ = motion_of(
        panel, lines, panel.patches, dense_psd(panel, lines, panel.patches, damping, mass)
    )
    np.testing.assert_allclose(response.acceleration_psd, points, rtol=1e-8)


@pytest.mark.parametrize("strength", [0.0, 1.0, 100.0])
def test_the_motion_of_a_patch_is_that_of_the_dense_solve(panel, lines, strength):
    # the eigenvectors of R_uu are no orthogonal ones: their condition costs some digits
    damping, mass = strength * lines.equivalent_damping[:1], strength * lines.apparent_mass[:1]
    patch = one_patch(panel)
    (motion,) = Motions(bare_of(panel, lines, patch), patch.area).acceleration_psd(damping, mass)
    modal_psd = dense_psd(panel, lines, patch, damping, mass)
    np.testing.assert_allclose(
        motion, motion_of(panel, lines, patch, modal_psd)[1][:, 0], rtol=1e-8
    )


def test_motions_beside_the_deflection_are_those_of_the_dense_solve(panel, lines):
    # two motions at each of two points, as curvatures are, and their cross-PSD
    rows = np.random.default_rng(3).standard_normal((2, 2, len(panel.modes)))
    response = attach_dampers(
        bare_of(panel, lines, motion_at_points=rows), lines.equivalent_damping, lines.apparent_mass
    )
    modal_psd = dense_psd(
        panel, lines, panel.patches, lines.equivalent_damping, lines.apparent_mass
    )
    expected = np.einsum("pai,fij,pbj->fpab", rows, modal_psd, rows)
    size = np.sqrt(np.einsum("fpaa,fpbb->fpab", expected, expected).real)
    assert np.max(np.abs(response.cross_psd - expected) / size) < 1e-10


def test_several_sets_of_patches_are_solved_as_if_each_were_alone(panel, lines):
    carriers = [one_patch(panel, 0), one_patch(panel, 1)]
    sound = panel.points, lines.spectrum, lines.modal_force
    together = bare_panels(lines.frequency, panel.basis, carriers, *sound)
    for index, bare in enumerate(together):
        alone = bare_of(panel, lines, carriers[index], overlap_cutoff=OVERLAP_CUTOFF)
        damper = lines.equivalent_damping[index : index + 1], lines.apparent_mass[index : index + 1]
        np.testing.assert_allclose(
            attach_dampers(bare, *damper).cross_psd,
            attach_dampers(alone, *damper).cross_psd,
            rtol=1e-10,
        )


def test_dropping_small_eigenvalues_of_the_overlap_costs_less_than_a_millionth(panel, lines):
    exact = attach_dampers(bare_of(panel, lines), lines.equivalent_damping, lines.apparent_mass)
    bare = bare_of(panel, lines, overlap_cutoff=OVERLAP_CUTOFF)
    fast = attach_dampers(bare, lines.equivalent_damping, lines.apparent_mass)
    assert bare.receptances.felt.shape[2] < bare_of(panel, lines).receptances.felt.shape[2]
    np.testing.assert_allclose(fast.acceleration_psd, exact.acceleration_psd, rtol=1e-6)


def test_a_hermitian_force_and_a_radiating_panel_are_the_dense_solve(panel, lines):
    # rank one, complex, as of a plane wave; 1e-10 as above
    phase = np.exp(1j * np.arange(len(panel.modes)) ** 2)
    wave = replace(lines, modal_force=np.outer(phase, phase.conj()) * 1e-3)
    resistance = air_resistance(lines.frequency, lines.modal_force, 2)
    omega = 2 * np.pi * lines.frequency[:, None, None]
    bare = bare_of(panel, wave, air_stiffness=1j * omega * resistance)
    response = attach_dampers(bare, lines.equivalent_damping, lines.apparent_mass)
    modal_psd = dense_psd(
        panel, wave, panel.patches, lines.equivalent_damping, lines.apparent_mass, resistance
    )
    points, _ = motion_of(panel, wave, panel.patches, modal_psd)
    np.testing.assert_allclose(response.acceleration_psd, points, rtol=1e-10)


def test_modal_force_may_be_one_matrix_one_a_line_or_a_function(panel, lines):
    many = replace(
        lines,
        frequency=np.geomspace(30.0, 1500.0, 300),
        spectrum=np.ones(300),
        modal_force=lines.modal_force[0] * np.geomspace(1.0, 30.0, 300)[:, None, None],
    )

    def of(frequency):
        position = np.searchsorted(many.frequency, frequency)
        return many.modal_force[position]

    none = np.zeros((2, 300))
    per_line = attach_dampers(bare_of(panel, many), none, none)
    function = attach_dampers(bare_of(panel, many, modal_force=of), none, none)
    np.testing.assert_array_equal(per_line.acceleration_psd, function.acceleration_psd)
    one = attach_dampers(bare_of(panel, many, modal_force=lines.modal_force[0]), none, none)
    scaled = one.acceleration_psd * np.geomspace(1.0, 30.0, 300)[:, None]
    np.testing.assert_allclose(per_line.acceleration_psd, scaled, rtol=1e-12)


class InColumns:
    """G that is also known as L Lᴴ; without factors, as where there are not few."""

    def __init__(self, factors, known=True):
        self.columns, self.known = factors, known

    def __call__(self, frequency):
        whole = self.columns @ self.columns.conj().T
        return np.broadcast_to(whole, (frequency.size, *whole.shape))

    def factors(self, frequency):
        if not self.known:
            return None
        return np.broadcast_to(self.columns, (frequency.size, *self.columns.shape))


@pytest.mark.parametrize("in_air", [False, True])
@pytest.mark.parametrize("phase", [0.0, 1.0])
def test_a_force_in_few_columns_answers_as_the_whole(panel, lines, in_air, phase):
    n = panel.basis.natural_frequency.size
    rng = np.random.default_rng(1)
    columns = rng.standard_normal((n, 3)) * np.exp(1j * phase * rng.standard_normal((n, 3)))
    columns = columns if phase else columns.real
    air = None
    if in_air:
        coupled = rng.standard_normal((n, n))
        air = (1 + 1j) * 1e3 * (coupled @ coupled.T)
    whole, few = (
        bare_of(panel, lines, modal_force=InColumns(columns, known), air_stiffness=air)
        for known in (False, True)
    )
    for name in ("felt", "across"):
        one, other = (getattr(bare.receptances, name) for bare in (few, whole))
        np.testing.assert_allclose(one, other, rtol=1e-13)
    for name in ("receptances.felt_psd", "receptances.across_psd", "point_psd"):
        one, other = (attrgetter(name)(bare) for bare in (few, whole))
        np.testing.assert_allclose(one, other, rtol=1e-9, atol=1e-12 * np.abs(other).max())


def test_the_bare_patches_move_as_their_reduced_motions_say(panel, lines):
    found = patch_motions_in_vacuum(
        lines.frequency, panel.basis, panel.patches, lines.spectrum, lines.modal_force
    )
    bare = bare_of(panel, lines)
    expected = np.einsum("pij,fji->fp", bare.coordinates.weight, bare.receptances.felt_psd).real
    np.testing.assert_allclose(found, expected / panel.patches.area, rtol=1e-7)


def one_mode_response(frequency, zeta, damping=0.0, mass=0.0):
    """One mode of 2 kg at 100 Hz with φ = 1 at the point and on a patch of 0.1 m²."""
    basis, patches = ModalBasis([100.0], [2.0], zeta), Patches(np.array([[[0.1]]]), np.array([0.1]))
    white = np.full(frequency.size, 4.0)
    (bare,) = bare_panels(frequency, basis, [patches], [[1.0]], white, [[1.0]])
    shape = (1, frequency.size)
    return attach_dampers(bare, np.full(shape, damping), np.full(shape, mass))


def test_a_plate_under_one_pressure_answers_as_nafems_13r_in_closed_form():
    # 10 × 10 × 0.05 m steel, simply supported, ζ = 2 %, one pressure of (100 Pa)²/Hz on the whole
    # face: 2064.24 mm²/Hz at the centre at the first natural frequency, in closed form (NAFEMS:
    # 2063.20). Six figures are given, and the series of sines ends to 1e-7 with 5 × 5 odd ones
    side, thickness, odd = 10.0, 0.05, [(m, n) for m in range(1, 11, 2) for n in range(1, 11, 2)]
    rigidity = 200e9 * thickness**3 / (12 * (1 - 0.3**2))
    m, n = np.array(odd).T
    wave_square = (np.pi / side) ** 2 * (m**2 + n**2)
    frequency = np.sqrt(rigidity / (8000 * thickness)) * wave_square / (2 * np.pi)
    assert frequency[0] == pytest.approx(2.377, abs=5e-4)
    force = (2 * side / np.pi) ** 2 / (m * n)  # ∫ sin sin dA
    center = np.sin(m * np.pi / 2) * np.sin(n * np.pi / 2)
    (bare,) = bare_panels(
        frequency[:1],
        ModalBasis(frequency, np.full(m.size, 8000 * thickness * side**2 / 4), 0.02),
        [Patches(np.zeros((0, m.size, m.size)), np.zeros(0))],
        center[None],
        [100.0**2],
        np.outer(force, force),
    )
    response = attach_dampers(bare, np.zeros((0, 1)), np.zeros((0, 1)))
    assert response.displacement_psd[0, 0] * 1e6 == pytest.approx(2064.24, rel=3e-6)


def test_a_dashpot_patch_adds_its_damping_and_a_mass_patch_its_mass():
    # C_e A = 30 N s/m beside 2ζmω = 50.27; m_a A = 0.5 kg beside 2 kg: Miles with the sums
    frequency = frequency_grid(1.0, 1e4, 0.02, [100.0])
    omega = 2 * np.pi * 100.0
    mass, damping = 2.0 + 0.5, 2 * 0.02 * 2.0 * omega + 30.0
    expected = np.sqrt(4.0 / (4 * damping * 2.0 * omega**2))  # S/(4 c k): Miles without ζ
    response = one_mode_response(frequency, 0.02, damping=300.0, mass=5.0)
    assert response.displacement_rms[0] == pytest.approx(expected, rel=5e-4)
    peak = frequency[np.argmax(response.displacement_psd[:, 0])]
    zeta = damping / (2 * np.sqrt(mass * 2.0) * omega)
    assert peak == pytest.approx(100 * np.sqrt(2.0 / mass) * np.sqrt(1 - 2 * zeta**2), rel=0.005)


def paper_form(panel, lines, patches):
    points = panel.points[:, None]
    return panel_in_shapes(
        lines.frequency,
        panel.basis,
        patches.diagonal,
        points,
        lines.spectrum,
        lines.modal_force,
    )


def test_the_diagonal_form_is_the_full_one_where_the_patch_covers_the_panel(panel, lines):
    # ∫ over the whole panel makes D diagonal, so the two forms are one; 1e-10 as above
    n = len(panel.modes)
    whole = Patches(np.eye(n)[None] * 1.5 / 4, np.array([1.5]))
    damping, mass = lines.equivalent_damping[:1] / 50, lines.apparent_mass[:1] / 50
    diagonal = attach_dampers(paper_form(panel, lines, whole), damping, mass)
    bare = bare_of(panel, lines, whole)
    full = attach_dampers(bare, damping, mass)
    np.testing.assert_allclose(diagonal.acceleration_psd, full.acceleration_psd, rtol=1e-10)


def test_a_small_patch_couples_modes_that_the_diagonal_form_keeps_apart(panel, lines):
    # 4-5 dB at 1-2 kHz off the patch with the paper's corrected law, of this size: why the
    # diagonal form is not the default
    damping, mass = 5 * lines.equivalent_damping, 0 * lines.apparent_mass
    diagonal = attach_dampers(paper_form(panel, lines, panel.patches), damping, mass)
    full = attach_dampers(bare_of(panel, lines), damping, mass)
    decibels = 10 * np.log10(diagonal.acceleration_psd / full.acceleration_psd)
    assert np.max(np.abs(decibels)) > 3.0


def test_a_panel_without_patches_answers_too(panel, lines):
    n = len(panel.modes)
    none = Patches(np.zeros((0, n, n)), np.zeros(0))
    empty = np.zeros((0, lines.frequency.size))
    alone = attach_dampers(bare_of(panel, lines, none), empty, empty)
    zero = np.zeros_like(lines.equivalent_damping)
    beside = attach_dampers(bare_of(panel, lines), zero, zero)
    np.testing.assert_allclose(alone.acceleration_psd, beside.acceleration_psd, rtol=1e-12)


def test_negative_damping_is_refused_as_unstable(panel, lines):
    damping = lines.equivalent_damping.copy()
    damping[1, 5] = -0.5
    with pytest.raises(UnstableDamping, match=r"-0.5 N s/m³ \(patch 1, line 5\).*unstable"):
        attach_dampers(bare_of(panel, lines), damping, lines.apparent_mass)
    with pytest.raises(UnstableDamping, match="unstable"):
        attach_dampers(paper_form(panel, lines, panel.patches), damping, lines.apparent_mass)


REFUSED = {
    "damping not finite": lambda panel, lines: attach_dampers(
        bare_of(panel, lines), lines.equivalent_damping * np.nan, lines.apparent_mass
    ),
    "one patch short": lambda panel, lines: attach_dampers(
        bare_of(panel, lines), lines.equivalent_damping[:1], lines.apparent_mass
    ),
    "frequency falls": lambda panel, lines: bare_of(panel, lines, frequency=lines.frequency[::-1]),
    "frequency zero": lambda panel, lines: bare_of(panel, lines, frequency=0 * lines.frequency),
    "frequency empty": lambda panel, lines: bare_of(panel, lines, frequency=[]),
    "psd negative": lambda panel, lines: bare_of(panel, lines, spectrum=-lines.spectrum),
    "force of another size": lambda panel, lines: bare_of(panel, lines, modal_force=np.eye(3)),
    "points of other modes": lambda panel, lines: bare_of(
        panel, lines, motion_at_points=np.ones((1, 3))
    ),
    "patches of other modes": lambda panel, lines: bare_of(
        panel, lines, Patches(np.eye(3)[None], np.ones(1))
    ),
    "overlap skew": lambda panel, _: Patches(np.triu(panel.patches.overlap), panel.patches.area),
    "overlap not finite": lambda *_: Patches([[[np.nan]]], [1.0]),
    "overlap negative": lambda *_: Patches([[[-1.0]]], [1.0]),
    "area zero": lambda *_: Patches([[[1.0]]], [0.0]),
    "rows not finite": lambda *_: Patches.of_rows(np.full((1, 2, 3), np.nan), [1.0]),
    "rows of other areas": lambda *_: Patches.of_rows(np.ones((1, 2, 3)), [1.0, 1.0]),
    "mass zero": lambda *_: ModalBasis([1.0], [0.0], 0.01),
    "undamped": lambda *_: ModalBasis([1.0], [1.0], 0.0),
    "masses of another list": lambda *_: ModalBasis([1.0], [1.0, 2.0], 0.1),
}


@pytest.mark.parametrize("name", REFUSED)
def test_what_has_no_response_is_refused(panel, lines, name):
    with pytest.raises(ResponseError):
        REFUSED[name](panel, lines)
