"""Linear dampers on the panel, against a solve of all its equations."""

import numpy as np
import pytest

from pidpanel.coupled import linear


@pytest.fixture(scope="module")
def damped(plate):
    """Frequencies, L and Z of the plate with a damper of its own at every station."""
    frequency = np.linspace(40, 500, 70)
    rng = np.random.default_rng(2)
    z = 300 * (1 + rng.random(8)) + 2j * np.pi * frequency[:, None] * (1 + rng.random(8))
    load = (z * plate.area)[:, :, None] * np.eye(8)
    felt = plate.shapes.at_stations.T
    omega = 2 * np.pi * frequency[:, None, None]
    stiffness = plate.stiffness(frequency)[:, :, None] * np.eye(plate.count)
    return frequency, load, stiffness + 1j * omega * (felt @ load @ felt.T)


def test_motion_is_that_of_all_equations(plate, damped):
    # red: `- (across` → `+ (across`; own @ force → own
    frequency, load, full = damped
    rng = np.random.default_rng(3)
    amplitude = rng.standard_normal((70, plate.count)) + 1j
    felt, seen = plate.shapes.at_stations.T, plate.shapes.at_points
    found = linear.motion(frequency, plate.stiffness(frequency), felt, load, seen, amplitude)
    wanted = np.linalg.solve(full, amplitude[:, :, None])[:, :, 0] @ seen.T
    assert found == pytest.approx(wanted, rel=1e-9)


def test_psds_are_those_of_all_equations(plate, damped):
    # of two dampers at once, the second with a force of its own
    # red: `sound + own_psd` → `sound`; row.conj() → row
    frequency, load, full = damped
    rng = np.random.default_rng(4)
    root = rng.standard_normal((plate.count, plate.count))
    force = root @ root.T
    own = np.diag(rng.random(plate.count))
    psd = 2.0 + np.sin(frequency / 50)
    seen = plate.shapes.at_points
    found = list(
        linear.point_psds(
            frequency,
            plate.stiffness(frequency),
            plate.shapes.at_stations.T,
            [0 * load, load],
            seen,
            psd,
            lambda f: np.broadcast_to(force, (len(f), *force.shape)),
            [lambda lines: 0 * own[None], lambda lines: own[None]],
        )
    )
    bare = plate.stiffness(frequency)[:, :, None] * np.eye(plate.count)
    for matrix, more, one in zip((bare, full), (0 * own, own), found, strict=True):
        row = seen @ np.linalg.inv(matrix)
        total = psd[:, None, None] * force + more
        wanted = np.einsum("fpi,fij,fpj->fp", row, total, row.conj()).real
        assert one == pytest.approx(wanted, rel=1e-9)
