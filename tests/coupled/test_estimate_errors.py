"""Errors of an estimate are the scatter of what they are errors of."""

import numpy as np
import pytest

from pidpanel.coupled.coupled_panel import CoupledPatch
from pidpanel.coupled.estimate import _leave_one_out, _patch_estimate, _PatchFit, _residual
from pidpanel.coupled.impedance import BandImpedance, ImpedanceSums
from pidpanel.coupled.own_force import OwnForce, own_force_sums
from pidpanel.solve.source import PatchParts

CENTRE = np.array([70.0, 140.0])
EDGE = np.array([[50.0, 100.0], [100.0, 200.0]])
LINES = np.linspace(50.0, 199.9, 30)
SIDE, CELLS, CELL_AREA = 0.2, 8, 4e-5
DAMPING, MASS = 400.0, 0.02


def patch(cells=CELLS):
    """A square patch with its cells in a row."""
    middle = SIDE / 4 * (np.arange(4) + 0.5)
    place = np.array([(a, b) for a in middle for b in middle])
    return CoupledPatch(
        shape=np.ones((cells, 1)),
        area=np.full(cells, SIDE**2 / cells),
        position=np.stack([SIDE * (np.arange(cells) + 0.5) / cells, np.full(cells, 0.1)], axis=1),
        cell_area=CELL_AREA,
        overlap=np.full((1, 1), SIDE**2),
        parts=PatchParts(np.ones((16, 1)), np.full(16, SIDE**2 / 16), place),
    )


def fitted(seed=1, segments=6, cells=CELLS, own=1.0, shared=False, damping=1.0, mass=1.0):
    """Sums of a patch of which all cells have one motion; C_e and m_a with factors of each cell.

    The mass is small, so that Z is about the same at all lines of a band.
    """
    rng = np.random.default_rng(seed)

    def noise(*size):
        return (rng.standard_normal(size) + 1j * rng.standard_normal(size)) / np.sqrt(2)

    motion = noise(segments, len(LINES), 1) * np.ones(cells)
    force = np.sqrt(own) * noise(segments, len(LINES), 1 if shared else cells) * np.ones(cells)
    z = DAMPING * damping + 2j * np.pi * LINES[:, None] * MASS * mass
    sums = ImpedanceSums.from_spectra(
        LINES, z * motion + force, motion, motion, np.full(cells, SIDE**2 / cells), EDGE
    )
    index = np.searchsorted(LINES, EDGE)
    lines = np.tile(index[:, 1] - index[:, 0], (segments, 1))
    return _PatchFit(patch(cells), sums, CENTRE, own_force_sums(LINES, force, EDGE), lines)


def same(one, other):
    return (
        np.allclose(one.psd, other.psd, rtol=1e-12)
        and np.allclose(one.coherence, other.coherence, rtol=1e-9, atol=1e-12)
        and one.length == other.length
    )


def test_what_is_left_out_of_the_own_force_is_as_if_it_had_not_been_recorded():
    fit = fitted()
    segments, cells = np.array([0, 1, 1, 0, 1, 1.0]), np.array([1, 1, 0, 1, 1, 0, 1, 1.0])
    few = _PatchFit(fit.patch, fit.sums, CENTRE, fit.force_sums[segments > 0], fit.lines[:4])
    assert same(fit.own_force(segments=segments), few.own_force())
    assert not same(fit.own_force(), few.own_force())
    power = np.einsum("sbcc->bc", fit.force_sums)[:, [0, 1, 3, 4, 6, 7]].sum(axis=1)
    found = fit.own_force(cells=cells).psd
    assert found == pytest.approx(power / fit.lines.sum(axis=0) / 6, rel=1e-12)


def test_a_patch_feels_what_its_cells_share_by_its_area():
    # c A² of what all share, at any distance, and (1 − c) A A_cell of what each has for itself
    force = OwnForce(np.array([5.0, 7.0]), np.array([0.002, 0.0]), 1e9)
    found = fitted().resultant(force)
    area = SIDE**2
    wanted = [5.0 * (0.002 * area**2 + 0.998 * CELL_AREA * area), 7.0 * CELL_AREA * area]
    assert found == pytest.approx(wanted, rel=1e-6)


def test_the_error_of_the_own_force_is_the_scatter_of_many_records():
    # one force of all cells, of 100 and 200 lines; 40 records know its scatter to 11 %
    values, stated = [], []
    for seed in range(40):
        fit = fitted(seed, segments=10, shared=True)
        force = fit.own_force()
        values.append(fit.resultant(force))
        flat = BandImpedance(CENTRE, np.ones(2) + 0j, np.zeros((2, 0)))
        stated.append(_patch_estimate(fit, flat, force, 1.0).own_force_error)
    scatter = np.std(values, axis=0) / np.mean(values, axis=0)
    assert scatter[1] == pytest.approx(1 / np.sqrt(200), rel=0.4)
    assert np.sqrt(np.mean(np.square(stated), axis=0)) == pytest.approx(scatter, rel=0.3)


def test_cells_that_differ_make_an_error_of_damping_and_of_mass():
    # s/√n of each, with no other chance
    turn = np.array([1, -1, 1, 1, -1, -1, 1, -1]) * np.sqrt(7 / 8)
    fit = fitted(own=0.0, damping=1 + 0.2 * turn, mass=1 + 0.3 * turn[::-1])
    z = fit.sums.impedance()
    found = _patch_estimate(fit, z, fit.own_force(), 1.0)
    root = np.sqrt(CELLS)
    wanted = np.full(2, 0.2 * DAMPING / root)
    assert found.equivalent_damping_error == pytest.approx(wanted, rel=0.02)
    assert found.apparent_mass_error == pytest.approx(np.full(2, 0.3 * MASS / root), rel=0.02)


def test_of_a_single_cell_the_deviations_are_the_error():
    # 3-4-5 and 5-12-13
    fit = fitted(cells=1)
    deviation = np.array([[3.0 + 5j, 4.0 - 12j], [6.0 + 10j, -8.0 + 24j]])
    z = BandImpedance(CENTRE, np.array([400.0 + 9j, 300.0 + 8j]), deviation)
    found = _patch_estimate(fit, z, fit.own_force(), 0.5)
    assert found.equivalent_damping_error == pytest.approx([5.0, 10.0])
    assert found.apparent_mass_error == pytest.approx(np.array([13.0, 26.0]) / (2 * np.pi * CENTRE))


def test_each_is_left_out_in_turn_and_a_single_one_never():
    assert _leave_one_out(2).tolist() == [[0, 1], [1, 0]]
    assert _leave_one_out(1).shape == (0, 1)
    single = fitted(cells=1, segments=1)
    assert not single.ratios(unit="segments")
    # so that no scatter is known
    z = BandImpedance(CENTRE, np.ones(2) + 0j, np.zeros((2, 0)))
    found = _patch_estimate(single, z, single.own_force(), 0.0)
    assert found.own_force_error.tolist() == [0.0, 0.0]


def test_a_residual_within_its_scatter_is_no_excess():
    # recorded squares are four times what was predicted, with a scatter of 0.3 from segment to
    # segment: what is taken off the square of the residual is its variance over 600 records
    rng = np.random.default_rng(1)
    predicted = np.exp(0.05 * rng.standard_normal((600, 8, 3)))
    recorded = 4.0 * predicted * (1 + 0.3 * rng.standard_normal((600, 8, 3)))
    values, excesses = np.swapaxes(
        [_residual(*pair) for pair in zip(recorded, predicted, strict=True)], 0, 1
    )
    assert np.mean(values, axis=0) == pytest.approx([np.log(4)] * 3, abs=0.02)
    taken = np.mean(values**2 - excesses**2, axis=0)
    assert taken == pytest.approx(np.var(values, axis=0), rel=0.25)
    # of points that are at rest, and of segments that are all alike
    value, excess = _residual(np.zeros((8, 1)), np.zeros((8, 1)))
    assert (value.tolist(), excess.tolist()) == ([0.0], [0.0])
    value, excess = _residual(1.1 * predicted[0], predicted[0])
    assert excess == pytest.approx([np.log(1.1)] * 3, rel=1e-9)
