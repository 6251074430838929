"""Several dampers on one panel: against dense matrices, and where they must superpose."""

import numpy as np
import pytest
from solving import panel_solver, solve_bare, solve_layout

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.solve import solvers
from pidpanel.solve.layout import AttachedDamper, DamperLayout, solve_with
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis, Patches, UnstableDamping
from pidpanel.solve.panel import PatchElements
from pidpanel.solve.power import power_balance
from pidpanel.solve.solvers import Request

FACTOR = 1.7
SEARCH = np.geomspace(30.0, 1500.0, 60)


def rows_over(panel, corner, size, cells=1, order=12):
    """√weight φ (cells², k, n) on Gauss points of cells × cells equal cells."""
    node, weight = np.polynomial.legendre.leggauss(order)
    side = np.array(size) / cells
    rows = []
    for number in range(cells**2):
        start = np.array(corner) + side * np.divmod(number, cells)
        x, y = np.meshgrid(*((1 + node) * half / 2 for half in side), indexing="ij")
        shape = panel.shape(np.stack([x.ravel(), y.ravel()], axis=1) + start)
        rows.append(np.sqrt(np.outer(weight, weight).ravel() * side.prod() / 4)[:, None] * shape)
    return np.stack(rows)


def patches_at(panel, places):
    """Patches from corners and sizes, as rows."""
    parts = [rows_over(panel, corner, size) for corner, size in places]
    area = np.array([size[0] * size[1] for _, size in places])
    return Patches.of_rows(np.concatenate(parts), area)


def spectrum(frequency):
    return 1e5 * (frequency / 100) ** -1.0


def force_on(panel):
    def force(frequency):
        """Real and smooth over frequency, from uniform to uncorrelated."""
        n = len(panel.modes)
        load = panel.shape(np.random.default_rng(0).uniform(0, 1, (200, 2)) * [1.5, 1.0]).mean(0)
        share = np.exp(-frequency / 300)[:, None, None]
        return share * np.outer(load, load) + (1 - share) * 0.02 * np.eye(n)

    return force


def solver_of(panel, patches, is_diagonal=False, frequency=SEARCH, **more):
    return panel_solver(
        panel.basis, patches, frequency, panel.points, force_on(panel), spectrum, SEARCH,
        is_diagonal=is_diagonal, **more,
    )  # fmt: skip


def constant(damping, mass):
    def law(f, _gamma):
        return damping * np.sqrt(f / 100), mass * (f / 100) ** -0.2, f < 1000

    return law


def follows(damping, exponent, mass):
    """C_e that falls with Γ as a power, m_a that falls slowly."""

    def law(f, gamma):
        return damping * np.sqrt(f / 100) * gamma**-exponent, mass * gamma**-0.1 + 0 * f, f > 0

    return law


def psd(found):
    return found.response.acceleration_psd


SMALL = [((0.30, 0.25), (0.06, 0.05)), ((1.0, 0.6), (0.05, 0.06))]
LARGE = [((0.20, 0.10), (0.5, 0.4)), ((0.6, 0.4), (0.6, 0.5))]  # they overlap


@pytest.fixture(params=["reduced", "direct"])
def places(request, panel):
    """Patches that a low-rank update carries, and ones that a dense solve does."""
    chosen = {"reduced": SMALL, "direct": LARGE}[request.param]
    width = patches_at(panel, chosen).coordinates(1e-8).columns.shape[1]
    assert (width > solvers.DIRECT_SHARE * len(panel.modes)) == (request.param == "direct")
    return chosen


def air(frequency):
    """−ω² M_air + iωR of some air that couples the shapes, half a kilogram of each."""
    shape = np.sin(np.arange(35)[:, None] + np.arange(3))
    mass = 0.1 * shape @ shape.T + 0.3 * np.eye(35)
    omega = 2 * np.pi * frequency[:, None, None]
    return -(omega**2) * mass + 1j * omega * 20 * (shape @ shape.T) * frequency[:, None, None] / 1e3


def dense(panel, patches, frequency, damping, mass, air_stiffness=None):
    """S_q line by line from the whole matrices."""
    sound, force = spectrum(frequency), force_on(panel)(frequency)
    found = []
    for line, f in enumerate(frequency):
        omega = 2 * np.pi * f
        Z = np.diag(panel.basis.dynamic_stiffness(frequency[line : line + 1])[0])
        if air_stiffness is not None:
            Z = Z + air_stiffness(frequency[line : line + 1])[0]
        for p, D in enumerate(patches.overlap):
            Z = Z + (1j * omega * damping[p, line] - omega**2 * mass[p, line]) * D
        H = np.linalg.inv(Z)
        found.append(sound[line] * H @ force[line] @ H.conj().T)
    return np.array(found)


def dampers(frequency):
    return (
        np.stack([900 * np.sqrt(frequency / 100), 300 * (frequency / 100) ** 0.8]),
        np.stack([6.4 * (frequency / 50) ** -0.3, np.full(frequency.size, 9.0)]),
    )


@pytest.mark.parametrize("in_air", [None, air])
def test_two_dampers_move_the_panel_as_the_whole_matrices_say(panel, places, in_air):
    # 1e-6: what the cutoff of D leaves out
    patches = patches_at(panel, places)
    solver = solver_of(panel, patches, air_stiffness=in_air)
    damping, mass = dampers(SEARCH)
    S = dense(panel, patches, SEARCH, damping, mass, in_air)
    omega4 = (2 * np.pi * SEARCH) ** 4
    (answer,) = solver.responses([Request((0, 1), damping, mass)])
    expected = omega4[:, None] * np.einsum("an,fnm,am->fa", panel.points, S, panel.points).real
    np.testing.assert_allclose(answer.acceleration_psd, expected, rtol=1e-6)
    motion = omega4 * np.einsum("pnm,fmn->pf", patches.overlap, S).real / patches.area[:, None]
    got = solver.motions((0, 1)).acceleration_psd(damping, mass)
    # the search drops more of D, and of the shapes far above a line: rms within 1e-3
    rms, own = (np.sqrt(np.trapezoid(one, SEARCH)) for one in (motion, got))
    np.testing.assert_allclose(own, rms, rtol=1e-3)


@pytest.mark.parametrize("is_diagonal", [False, True])
def test_slopes_of_each_of_two_dampers_are_those_of_responses_to_slightly_other_ones(
    panel, places, is_diagonal
):
    # central differences over 2e-5 of the damper; beside a sharp peak their error is 2e-7 of the
    # slope's scale, rounding 1e-12 over them as much
    solver = solver_of(panel, patches_at(panel, places), is_diagonal)
    damping, mass = dampers(SEARCH)
    omega, step = 2 * np.pi * SEARCH, 2e-5
    motions = solver.motions((0, 1))
    (answer,) = solver.responses([Request((0, 1), damping, mass, with_slope=True)])
    slope = motions.acceleration_slope(damping, mass)
    for load in (0, 1):
        for part in (0, 1):
            change = [np.zeros_like(damping), np.zeros_like(mass)]
            change[part][load] = (damping, mass)[part][load]
            push = 1j * omega * change[0][load] - omega**2 * change[1][load]
            up, down = (
                (damping + sign * step * change[0], mass + sign * step * change[1])
                for sign in (1, -1)
            )
            ends = [one.acceleration_psd for one in solver.responses(
                [Request((0, 1), *up), Request((0, 1), *down)])]  # fmt: skip
            got = -2 * (push[:, None] * answer.slope[load]).real
            scale = np.abs(ends[0]).max(axis=1, keepdims=True)
            np.testing.assert_allclose(
                got / scale, (ends[0] - ends[1]) / (2 * step) / scale, atol=1e-6
            )
            ends = [motions.acceleration_psd(*one) for one in (up, down)]
            got = -2 * (push * slope[:, load]).real
            scale = np.abs(ends[0]).max(axis=0)
            np.testing.assert_allclose(
                got / scale, (ends[0] - ends[1]) / (2 * step) / scale, atol=1e-6
            )


# ------------------------------------------------------------------ superposition


@pytest.mark.parametrize("is_diagonal", [False, True])
def test_a_patch_in_two_halves_is_the_whole_patch(panel, is_diagonal):
    # exact in the full form and in the diagonals of D, which add up; the cutoff of D leaves 4e-6
    # at a sharp peak of so strongly damped a panel
    whole = [((0.5, 0.3), (0.2, 0.2))]
    halves = [((0.5, 0.3), (0.1, 0.2)), ((0.6, 0.3), (0.1, 0.2))]
    law = constant(1500.0, 6.0)
    one = solve_layout(
        solver_of(panel, patches_at(panel, whole), is_diagonal),
        [AttachedDamper(0, law, False)],
        1.0,
    )
    two = solve_layout(
        solver_of(panel, patches_at(panel, halves), is_diagonal),
        [AttachedDamper(0, law, False), AttachedDamper(1, law, False)],
        1.0,
    )
    np.testing.assert_allclose(psd(two), psd(one), rtol=1e-5)
    square = np.mean(two.patch_acceleration_g**2)  # halves of one area
    assert square == pytest.approx(one.patch_acceleration_g[0] ** 2, rel=1e-3)


def test_the_order_of_loads_plays_no_part_and_comes_back(panel, places):
    solver = solver_of(panel, patches_at(panel, places))
    laws = [follows(9000.0, 0.6, 5.0), follows(4000.0, 0.3, 9.0)]
    ways = [solve_layout(solver, [AttachedDamper(p, laws[p]) for p in order], FACTOR) for order in ((0, 1), (1, 0))]  # fmt: skip
    assert [way.patches.tolist() for way in ways] == [[0, 1], [1, 0]]
    # two searches, each closed to 1e-6
    np.testing.assert_allclose(ways[1].acceleration_g[::-1], ways[0].acceleration_g, rtol=1e-5)
    np.testing.assert_allclose(psd(ways[1]), psd(ways[0]), rtol=1e-5)


def test_dead_weight_takes_no_power_and_needs_no_search(panel, places):
    asked = []

    def weight(f, gamma):
        asked.append(gamma)
        return 0 * f, 0 * f + 7.0, f > 0

    patches = patches_at(panel, places)
    solver = solver_of(panel, patches)
    found = solve_layout(
        solver, [AttachedDamper(0, weight, False), AttachedDamper(1, weight, False)], 1.0
    )
    assert np.isnan(asked).all() and np.isnan(found.acceleration_g).all()
    assert (found.fixed_points, found.residual) == (1, 0.0)
    some = slice(None, None, 20)
    balance = power_balance(
        SEARCH[some], panel.basis, patches, spectrum(SEARCH[some]), force_on(panel),
        found.equivalent_damping[:, some], found.apparent_mass[:, some],
    )  # fmt: skip
    assert np.all(balance.patches == 0)
    assert balance.error.max() < 1e-6  # the cutoff of D


# ------------------------------------------------------------------ the motions


@pytest.mark.parametrize("is_diagonal", [False, True])
def test_the_motions_read_are_the_motions_that_result(panel, places, is_diagonal):
    # Γ of each patch from the whole matrices with the damping found, the sound FACTOR times that
    # of the solver
    patches = patches_at(panel, places)
    solver = solver_of(panel, patches, is_diagonal)
    loads = [
        AttachedDamper(0, follows(9000.0, 0.6, 5.0)),
        AttachedDamper(1, follows(4000.0, 0.3, 9.0)),
    ]
    found = solve_layout(solver, loads, FACTOR)
    assert found.residual <= 1e-6 and found.fixed_points == 1
    np.testing.assert_allclose(found.patch_acceleration_g, found.acceleration_g, rtol=2e-6)
    for load, gamma in zip(loads, found.acceleration_g, strict=True):
        at = found.equivalent_damping[load.patch]
        np.testing.assert_allclose(at, load.damping(SEARCH, gamma)[0])
    # in the diagonal form too, damping is read at the motion of the full one
    S = dense(panel, patches, SEARCH, found.equivalent_damping, found.apparent_mass)
    motion = np.einsum("pnm,fmn->pf", patches.overlap, S).real / patches.area[:, None]
    rms = np.sqrt(FACTOR * np.trapezoid((2 * np.pi * SEARCH) ** 4 * motion, SEARCH))
    np.testing.assert_allclose(found.acceleration_g, np.sqrt(2) * rms / STANDARD_GRAVITY, rtol=1e-3)


def two_modes(is_diagonal=False):
    """Two modes that do not know of each other, a patch on each."""
    lines = frequency_grid(20.0, 400.0, 0.02, [65.0, 180.0])
    overlap = 0.04 * np.array([[[1.0, 0], [0, 0]], [[0, 0], [0, 1.0]]])
    basis, patches = ModalBasis([65.0, 180.0], [1.5, 1.5], 0.02), Patches(overlap, [0.04, 0.04])
    force = np.diag([0.3, 0.2])
    return panel_solver(basis, patches, lines, np.eye(2), force, is_diagonal=is_diagonal)


@pytest.mark.parametrize("is_diagonal", [False, True])
def test_dampers_on_modes_that_do_not_meet_are_as_each_alone(is_diagonal):
    solver = two_modes(is_diagonal)
    laws = [follows(3000.0, 1.2, 1.0), follows(900.0, -0.5, 4.0)]
    together = solve_layout(
        solver, [AttachedDamper(0, laws[0]), AttachedDamper(1, laws[1])], FACTOR
    )
    for patch, law in enumerate(laws):
        alone = solve_layout(solver, [AttachedDamper(patch, law)], FACTOR)
        assert together.acceleration_g[patch] == pytest.approx(alone.acceleration_g[0], rel=1e-5)
        np.testing.assert_allclose(psd(together)[:, patch], psd(alone)[:, patch], rtol=1e-5)


def test_several_motions_of_a_layout_are_counted_and_the_most_governs():
    # damping that falls by a factor of 2000 about Γ = 16 has three motions on each of two modes,
    # of which the middle one is repelling and is not reached by one damper
    def steep(f, gamma):
        return 2e4 / (1 + (gamma / 16) ** 16) + 10 + 0 * f, 0 * f, f > 0

    solver = two_modes()
    alone = [solve_layout(solver, [AttachedDamper(patch, steep)], 100.0) for patch in (0, 1)]
    assert [one.fixed_points for one in alone] == [2, 2]
    found = solve_layout(solver, [AttachedDamper(0, steep), AttachedDamper(1, steep)], 100.0)
    assert found.fixed_points >= 4
    expected = np.concatenate([one.acceleration_g for one in alone])
    np.testing.assert_allclose(found.acceleration_g, expected, rtol=1e-5)


def test_a_law_without_motion_and_one_with_it_stand_side_by_side(panel, places):
    solver = solver_of(panel, patches_at(panel, places))
    found = solve_layout(
        solver,
        [
            AttachedDamper(0, follows(9000.0, 0.6, 5.0)),
            AttachedDamper(1, constant(300.0, 2.0), False),
        ],
        1.0,
    )
    assert np.isnan(found.acceleration_g).tolist() == [False, True]
    assert found.patch_acceleration_g[0] == pytest.approx(found.acceleration_g[0], rel=2e-6)
    assert found.inside.all(axis=1).tolist() == [True, False]


@pytest.mark.parametrize(("is_diagonal", "in_air"), [(False, None), (False, air), (True, None)])
def test_the_bare_panel_knows_the_motion_of_every_patch(panel, places, is_diagonal, in_air):
    patches = patches_at(panel, places)
    solver = solver_of(panel, patches, is_diagonal, air_stiffness=in_air)
    solver.prepare([(0, 1)])
    found = solve_bare(solver, FACTOR)
    none = np.zeros((2, SEARCH.size))
    S = dense(panel, patches, SEARCH, none, none, in_air)
    motion = np.einsum("pnm,fmn->pf", patches.overlap, S).real / patches.area[:, None]
    rms = np.sqrt(FACTOR * np.trapezoid((2 * np.pi * SEARCH) ** 4 * motion, SEARCH))
    np.testing.assert_allclose(
        found.bare_patch_acceleration_g, np.sqrt(2) * rms / STANDARD_GRAVITY, rtol=1e-3
    )
    assert found.acceleration_g.size == found.fixed_points == 0


# ------------------------------------------------------------------ by element


def test_cells_of_a_patch_say_what_its_mean_hides(panel, places):
    # against ∫ω⁴ S_q of the whole matrices
    damping, mass = dampers(SEARCH)
    patches = patches_at(panel, places)
    rows = np.concatenate([rows_over(panel, *place, cells=3) for place in places])
    cells = Patches.of_rows(rows, np.repeat([size[0] * size[1] / 9 for _, size in places], 9))
    solver = solver_of(panel, patches, cells=PatchElements(cells, np.repeat([0, 1], 9)))
    loads = [
        AttachedDamper(p, lambda f, _g, p=p: (damping[p], mass[p], f > 0), False) for p in (0, 1)
    ]
    found = solve_layout(solver, loads, FACTOR)
    S = dense(panel, patches, SEARCH, damping, mass).real
    total = FACTOR * np.trapezoid((2 * np.pi * SEARCH[:, None, None]) ** 4 * S, SEARCH, axis=0)
    square = np.einsum("cnm,mn->c", cells.overlap, total) / cells.area
    gamma = np.sqrt(2 * square).reshape(2, 9) / STANDARD_GRAVITY
    expected = np.stack([gamma.min(axis=1), gamma.max(axis=1)], axis=1)
    np.testing.assert_allclose(found.cell_acceleration_g, expected, rtol=2e-3)
    # the mean square over the cells is that of the patch
    mean = np.sqrt(np.mean(gamma**2, axis=1))
    np.testing.assert_allclose(found.patch_acceleration_g, mean, rtol=1e-3)


def test_every_cell_with_a_motion_of_its_own(panel):
    # 36 cells of one patch: where C_e does not depend on Γ they are the patch; where it does,
    # each reproduces its own motion
    corner, size = (0.5, 0.3), (0.24, 0.2)
    rows = rows_over(panel, corner, size, cells=6, order=6)
    cells = Patches.of_rows(rows, np.full(36, 0.24 * 0.2 / 36))
    by_cell = solver_of(panel, cells)
    by_patch = solver_of(panel, patches_at(panel, [(corner, size)]))
    same = constant(900.0, 6.0)
    every = solve_layout(by_cell, [AttachedDamper(c, same, False) for c in range(36)], 1.0)
    whole = solve_layout(by_patch, [AttachedDamper(0, same, False)], 1.0)
    np.testing.assert_allclose(psd(every), psd(whole), rtol=1e-6)
    found = solve_layout(
        by_cell, [AttachedDamper(c, follows(9000.0, 0.7, 5.0)) for c in range(36)], 1.0
    )
    assert found.residual <= 1e-6
    np.testing.assert_allclose(found.patch_acceleration_g, found.acceleration_g, rtol=2e-6)
    assert found.acceleration_g.max() > 1.05 * found.acceleration_g.min()


# ------------------------------------------------------------------ the run over the lines


def test_layouts_together_are_those_alone(panel, places):
    frequency = np.geomspace(30.0, 1500.0, 300)  # ten chunks of lines
    patches = patches_at(panel, places)
    layouts = [
        DamperLayout(
            [AttachedDamper(p, constant(900.0, 6.0), False) for p in loaded], 1.0, with_slope=True
        )
        for loaded in ((0, 1), (0,), (), (1,))
    ]
    together = solve_with(solver_of(panel, patches, frequency=frequency), layouts)
    solver = solver_of(panel, patches, frequency=frequency)
    for layout, one in zip(layouts, together, strict=True):
        (alone,) = solve_with(solver, [layout])
        np.testing.assert_allclose(psd(alone), psd(one), rtol=1e-12)
        np.testing.assert_allclose(alone.response.slope, one.response.slope, rtol=1e-9)


def test_a_layout_that_feeds_the_panel_is_told_in_its_place(panel, places):
    solver = solver_of(panel, patches_at(panel, places))
    good, bad = constant(900.0, 6.0), constant(-900.0, 6.0)
    found = solve_with(
        solver,
        [
            DamperLayout([AttachedDamper(0, good, False), AttachedDamper(1, law, False)])
            for law in (good, bad, good)
        ],
    )
    assert [isinstance(one, UnstableDamping) for one in found] == [False, True, False]
    np.testing.assert_array_equal(psd(found[2]), psd(found[0]))


# ------------------------------------------------------------------ patches from rows


def test_patches_from_rows_are_those_from_their_overlap(panel):
    rows = rows_over(panel, (0.2, 0.3), (0.4, 0.3), cells=2)
    made = Patches.of_rows(rows, np.full(4, 0.03))
    overlap = rows.swapaxes(1, 2) @ rows
    np.testing.assert_allclose(made.overlap, overlap, atol=1e-12 * overlap.max())
    np.testing.assert_allclose(made.diagonal, np.diagonal(overlap, axis1=1, axis2=2), atol=1e-14)
    other = Patches(overlap, made.area)
    for cutoff in (1e-4, 1e-8):
        widths = [[u.shape[1] for u in one.factors(cutoff)] for one in (made, other)]
        assert widths[0] == widths[1]
        for one in (made, other):
            E = one.coordinates(cutoff)
            back = E.columns @ E.weight @ E.columns.T
            # the eigenvalues dropped, of each patch and of all together
            assert np.max(np.abs(back - overlap)) < 3 * cutoff**0.5 * overlap.max()
            np.testing.assert_allclose(E.inverse @ E.columns, np.eye(E.columns.shape[1]), atol=1e-9)
