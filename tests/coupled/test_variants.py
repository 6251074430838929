"""The response and its changes with C_e, m_a and own force, against a solve of all equations."""

from types import SimpleNamespace

import numpy as np
import pytest
import scipy.optimize

from pidpanel.coupled.coupled_panel import CoupledPanel, CoupledPatch
from pidpanel.coupled.own_force import OwnForce
from pidpanel.coupled.variants import Variants, simulated_psd
from pidpanel.solve.bands import band_rms
from pidpanel.solve.excitation import ModalForce
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.source import PatchParts

LINES = np.geomspace(45.0, 320.0, 500)
CENTRE = np.array([63.0, 100.0, 160.0, 250.0])
EDGE = np.array([[45.0, 80.0], [80.0, 125.0], [125.0, 200.0], [200.0, 320.0]])
NATURAL = np.array([60.0, 110.0, 180.0, 260.0])
ONES = np.ones(4)
DAMPING, MASS = np.array([300.0, 500.0]), np.array([2.0, 1.0])


def damper(damping, mass):
    return lambda f: damping + 2j * np.pi * f * mass


def made(size=1.0, level=1.0):
    """Four shapes with two patches; the lighter they are, the less their dampers and forces are."""
    rng = np.random.default_rng(4)
    patches = []
    for k in range(2):
        parts = PatchParts(
            rng.uniform(-1, 1, (6, 4)), np.full(6, 0.01), 0.1 * rng.random((6, 2)) + 0.3 * k
        )
        weighted = parts.shape * parts.area[:, None]
        patches.append(
            CoupledPatch(
                shape=parts.shape[:3],
                area=np.array([0.01, 0.02, 0.03]),
                position=parts.position[:3],
                cell_area=4e-5,
                overlap=weighted.T @ parts.shape,
                parts=parts,
            )
        )
    root = 0.1 * rng.standard_normal((4, 4))
    panel = CoupledPanel(
        modal=ModalBasis(NATURAL, size * np.array([0.7, 0.5, 0.6, 0.4]), 0.03),
        points=rng.uniform(-1, 1, (2, 4)),
        patches=patches,
        excitation=ModalForce(lambda f: level * size**2 * f / 100, root @ root.T),
    )
    forces = [
        OwnForce(level * size**2 * scale * np.array([100.0, 400.0, 200.0, 50.0]), 0.2 * ONES, 30.0)
        for scale in (1.0, 3.0)
    ]
    return SimpleNamespace(panel=panel, forces=forces, size=size)


def closed_form(case, damping, mass, own):
    """PSDs (nf, p + c); ``own`` are factors of the own force of each patch over frequency."""
    panel = case.panel
    omega = 2j * np.pi * LINES[:, None, None]
    full = panel.modal.dynamic_stiffness(LINES)[:, :, None] * np.eye(4)
    force = panel.excitation.spectrum(LINES)[:, None, None] * panel.excitation(LINES)
    place = np.log(LINES)
    for patch, c, m, ratio, given in zip(
        panel.patches, damping, mass, own, case.forces, strict=True
    ):
        full = full + omega * case.size * (c + omega * m) * patch.overlap
        loads = np.array(
            [
                psd * (share * patch.parts.coherent_load(given.length / f)
                       + (1 - share) * patch.cell_area * patch.overlap)
                for psd, share, f in zip(given.psd, given.coherence, CENTRE, strict=True)
            ]
        )  # fmt: skip
        flat = [np.interp(place, np.log(CENTRE), column) for column in loads.reshape(4, -1).T]
        force = force + np.reshape(ratio, (-1, 1, 1)) * np.transpose(flat).reshape(-1, 4, 4)
    rows = np.concatenate([panel.points, panel.at_cells]) @ np.linalg.inv(full)
    return np.einsum("fpi,fij,fpj->fp", rows, force, rows.conj()).real


def computed(case):
    impedances = [damper(case.size * c, case.size * m) for c, m in zip(DAMPING, MASS, strict=True)]
    return Variants(case.panel, LINES, CENTRE, impedances, case.forces)


def test_the_own_force_of_each_patch_adds_to_the_response():
    case = made()
    found = computed(case)
    linear, whole, first = (
        closed_form(case, DAMPING, MASS, own) for own in ((0, 0), (1, 1), (1, 0))
    )
    assert found.linear_psd == pytest.approx(linear, rel=1e-6)
    assert found.psd == pytest.approx(whole, rel=1e-6)
    assert found.own_psd[0] == pytest.approx(first - linear, rel=1e-4, abs=1e-9 * whole.max())
    assert np.median(whole / linear) > 1.05


@pytest.mark.parametrize("size", [1e-5, 1.0])
@pytest.mark.parametrize("patch", [0, 1])
def test_derivatives_are_those_of_the_whole_response(size, patch):
    # central differences of 1 %; whatever the units, so to say: a light panel with light dampers
    case = made(size)
    found = computed(case)
    step = 0.01 * np.eye(2)[patch]
    for values, derivative, of_damping in (
        (DAMPING, found.of_damping[patch], True),
        (MASS, found.of_mass[patch], False),
    ):
        ends = []
        for sign in (1, -1):
            changed = values * (1 + sign * step)
            both = (changed, MASS) if of_damping else (DAMPING, changed)
            ends.append(closed_form(case, *both, (1, 1)))
        wanted = (ends[0] - ends[1]) / (0.02 * values[patch] * size)
        assert np.abs(derivative - wanted).max() < 0.03 * np.abs(wanted).max()


@pytest.mark.parametrize("level", [1e-14, 1.0])
def test_changes_are_those_of_the_whole_response(level):
    # first order in changes of up to 2 %, of panels that hardly move too
    case = made(level=level)
    found = computed(case)
    damping, mass = DAMPING * [1.015, 0.99], MASS * [0.985, 1.02]
    ratios = [np.array([1.0, 1.02, 0.98, 1.03]), np.array([0.97, 1.0, 1.04, 1.0])]
    changed = [damper(c, m) for c, m in zip(damping, mass, strict=True)]
    own = [np.interp(np.log(LINES), np.log(CENTRE), ratio) for ratio in ratios]
    before, after = (
        closed_form(case, DAMPING, MASS, (1, 1)),
        closed_form(case, damping, mass, own),
    )
    change = found.change(changed, ratios)
    wanted = np.log(after / before)
    assert np.abs(change - wanted).max() < 0.04 * np.abs(wanted).max()
    of_damper = found.change(changed, [np.ones(4)] * 2)
    wanted = np.log(closed_form(case, damping, mass, (1, 1)) / before)
    assert np.abs(of_damper - wanted).max() < 0.04 * np.abs(wanted).max()
    points = [(2 * np.pi * LINES[:, None]) ** 4 * psd[:, :2] for psd in (before, after)]
    total = np.log(np.divide(*(np.trapezoid(psd, LINES, axis=0) for psd in points[::-1])))
    assert found.total_change(change) == pytest.approx(total, rel=0.05, abs=2e-4)
    bands = 2 * np.log(np.divide(*(band_rms(LINES, psd, EDGE) for psd in points[::-1])))
    assert found.band_change(change, EDGE) == pytest.approx(bands, rel=0.06, abs=6e-4)


def test_damping_follows_the_motion_as_it_changes_the_motion():
    # C_e ∝ v^−0.75 of each patch, with v of all dampers: solved for without a linearisation
    case = made()
    parts = [slice(2, 5), slice(5, 8)]
    weight = np.array([1, 2, 3]) / 6

    def squares(damping):
        psd = (2 * np.pi * LINES[:, None]) ** 2 * closed_form(case, damping, MASS, (1, 1))
        return np.array([np.trapezoid(psd[:, part] @ weight, LINES) for part in parts])

    recorded = squares(DAMPING) * [1.006, 0.997]

    def apart(log_factor):
        ratio = recorded / squares(DAMPING * np.exp(log_factor))
        return log_factor - 0.75 / 2 * np.log(ratio)

    wanted = scipy.optimize.fsolve(apart, [0.0, 0.0])
    found = np.log(computed(case).at_motion(recorded))
    assert np.abs(found - wanted).max() < 0.003 * np.abs(wanted).max()


def test_the_own_force_of_the_simulated_cells_moves_the_points():
    # recorded sums over 5 + 3 lines, of cells that pull together; dampers in the cells alone
    case = made()
    rng = np.random.default_rng(6)
    lines = np.tile([[5], [3]], (1, 4))
    root = rng.standard_normal((2, 2, 4, 3, 3))
    sums = root @ np.swapaxes(root, -1, -2)  # (patch, segment, band, cell, cell)
    dampers = [damper(c, m) for c, m in zip(DAMPING, MASS, strict=True)]
    found = simulated_psd(case.panel, LINES, CENTRE, dampers, sums, lines)
    full, force = (
        case.panel.modal.dynamic_stiffness(LINES)[:, :, None] * np.eye(4),
        np.zeros((500, 4, 4)),
    )
    for k, patch in enumerate(case.panel.patches):
        for shape, area in zip(patch.shape, patch.area, strict=True):
            z = dampers[k](LINES) * area * 2j * np.pi * LINES
            full = full + z[:, None, None] * np.outer(shape, shape)
        for i in range(3):
            for j in range(3):
                psd = np.interp(np.log(LINES), np.log(CENTRE), sums[k, :, :, i, j].sum(axis=0) / 8)
                both = np.outer(patch.area[i] * patch.shape[i], patch.area[j] * patch.shape[j])
                force = force + psd[:, None, None] * both
    rows = case.panel.points @ np.linalg.inv(full)
    wanted = np.einsum("fpi,fij,fpj->fp", rows, force, rows.conj()).real
    assert found == pytest.approx(wanted, rel=1e-6)
