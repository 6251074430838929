"""Base motion against closed forms: an oscillator, a simply supported plate, its limits."""

from functools import partial

import numpy as np
import pytest
import scipy.sparse.linalg as spla
from moving import (
    APPARENT,
    DAMPING,
    HIGHEST,
    LEVEL,
    MASS,
    MASS_PER_AREA,
    NATURAL,
    RATIO,
    SIZE,
    STIFFNESS,
    ZETA,
    oscillator,
    panel_of,
    solved,
)

from pidpanel.solve.lines import frequency_grid

pytestmark = pytest.mark.verification

POINTS = {"(0.75, 0.5)": (0.75, 0.5), "(0.3, 0.3)": (0.3, 0.3)}  # [m]


@pytest.fixture(scope="module")
def plate(tmp_path_factory):
    """The simply supported plate of the paper, ζ = 2 %, with one patch."""
    return panel_of(tmp_path_factory.mktemp("plate"), elements=(30, 20), points=POINTS)


@pytest.fixture
def row(record):
    return partial(record, method="30 × 20 elements")


def test_an_oscillator_under_white_base_acceleration_has_its_closed_forms(record):
    row = partial(
        record, case="Oscillator on a moving base",
        method="the solver of the response with a translation",
    )  # fmt: skip
    frequency = np.array([20.0, 50.0, 120.0])
    r = frequency / NATURAL
    closed = LEVEL * np.stack([1 + (2 * ZETA * r) ** 2, r**4])
    closed /= (1 - r**2) ** 2 + (2 * ZETA * r) ** 2
    computed = oscillator(frequency)
    for line, f in enumerate(frequency):
        for name, values, exact in zip(("absolute", "relative"), computed, closed, strict=False):
            row(
                f"{name} acceleration PSD at {f:g} Hz", values[line], exact[line],
                unit="m2/s4/Hz", tolerance=1e-6, source="closed form",
            )  # fmt: skip
    lines = frequency_grid(2e-4, 1e7, ZETA)
    # the rule on lines even in ln f by h = ζ/4 is h²/6 high, 2.6e-5; half of that in the rms
    rms = np.sqrt(np.trapezoid(oscillator(lines)[0], lines))
    miles = np.sqrt(LEVEL * np.pi * NATURAL * (1 + 4 * ZETA**2) / (4 * ZETA))
    row(
        "rms of the absolute acceleration", rms, miles, unit="m/s2", tolerance=2e-5,
        source="Miles 1954, exact",
    )  # fmt: skip


def table_frequency(m, n):
    """Natural frequencies of the plate [Hz]."""
    k = np.pi**2 * ((m / SIZE[0]) ** 2 + (n / SIZE[1]) ** 2)
    return np.sqrt(STIFFNESS / MASS_PER_AREA) * k / (2 * np.pi)


def transmissibility(panel, frequency, *damper):
    """Ratios of absolute accelerations at the points (nf, 2), force per acceleration (nf,)."""
    motion, force, _ = solved(panel, frequency, *damper)
    return -((2 * np.pi * frequency[:, None]) ** 2) * motion[:, :-1, 0], force


def navier(frequency, highest=400):
    """The same by 40 000 modes."""
    m, n = (k.ravel() for k in np.meshgrid(*2 * [np.arange(1, highest, 2)], indexing="ij"))
    natural, omega = 2 * np.pi * table_frequency(m, n), 2 * np.pi * frequency[:, None]
    gain = omega**2 / (natural**2 - omega**2 + 2j * RATIO * natural * omega)
    shape = np.array(
        [
            np.sin(m * np.pi * x / SIZE[0]) * np.sin(n * np.pi * y / SIZE[1])
            for x, y in POINTS.values()
        ]
    )
    part = 16 / (np.pi**2 * m * n)
    return 1 + gain @ (part * shape).T, MASS * (1 + gain @ (part**2 / 4))


def test_a_simply_supported_plate_moves_as_its_modal_series(row, plate):
    row = partial(
        row, tolerance=2e-4, case="Simply supported plate on a moving base",
        source="modal series of 40 000 terms",
    )  # fmt: skip
    frequency = np.array([40.0, 64.9, 180.0, 224.7])
    (gain, force), (exact, whole) = transmissibility(plate, frequency), navier(frequency)
    for line, f in enumerate(frequency):
        for name, *pair in zip(POINTS, abs(gain[line]), abs(exact[line]), strict=True):
            row(f"transmissibility at {name}, {f:g} Hz", *pair)
        row(f"force over acceleration, {f:g} Hz", abs(force[line]), abs(whole[line]), unit="kg")


def test_near_rest_all_moves_with_the_supports_and_effective_masses_sum_to_the_mass(row, plate):
    row = partial(row, case="Limits of base motion", unit="kg")
    gain, force = transmissibility(plate, np.array([0.02]), 0.0, APPARENT)
    for name, value in zip(POINTS, abs(gain[0]), strict=True):
        row(
            f"transmissibility at {name}, 0.02 Hz", value, 1.0, unit="1", tolerance=1e-6,
            source="rigid motion",
        )  # fmt: skip
    row(
        "force over acceleration, 0.02 Hz, with particles", abs(force[0]),
        MASS + APPARENT * plate.patches.area[0], tolerance=1e-6,
        source="mass of panel and particles",
    )  # fmt: skip
    basis = plate.supported.basis
    modes = plate.inertia.effective_mass(basis.modal_mass)[~basis.is_residual]
    m, n = np.meshgrid(*2 * [np.arange(1, 40, 2)])
    below = 1.001 * basis.natural_frequency[~basis.is_residual].max()
    series = (64 / np.pi**4 * MASS / (m * n) ** 2)[table_frequency(m, n) < below]
    row(
        f"sum of the effective masses of the modes to {2 * HIGHEST:g} Hz", modes.sum(),
        series.sum(), tolerance=2e-4, source="64 M/(π⁴ m² n²)",
    )  # fmt: skip
    inertia = plate.plate.inertia
    row(
        "sum of the effective masses of all elements",
        inertia @ spla.spsolve(plate.plate.mass.tocsc(), inertia), MASS, tolerance=0.02,
        source="mass of the plate, less that of elements at the supports",
    )  # fmt: skip


def test_dampers_pull_at_the_absolute_motion_and_take_what_the_shaker_gives(row, plate):
    frequency = np.array([30.0, 65.0, 224.0, 390.0])
    motion, force, _ = solved(plate, frequency, DAMPING, APPARENT)
    modal, D, L = plate.modal, plate.basis.patch_overlap[0], plate.inertia.participation
    n = len(modal.damping) - 1
    for line, f in enumerate(frequency):
        omega = 2 * np.pi * f
        s, z = 1j * omega * DAMPING - omega**2 * APPARENT, -1 / omega**2  # of a unit acceleration
        stiffness = np.diag(modal.dynamic_stiffness(np.array([f]))[0, :n]) + s * D[:n, :n]
        q = np.append(np.linalg.solve(stiffness, omega**2 * L * z - s * D[:n, n] * z), z)
        np.testing.assert_allclose(motion[line], plate.observed @ q, rtol=1e-6, atol=-1e-9 * z)
        lost = modal.damping[:n] @ np.abs(q[:n]) ** 2 + DAMPING * np.real(q.conj() @ D @ q)
        row(
            f"power of the shaker per acceleration squared, {f:g} Hz",
            0.5 * np.real(force[line] * np.conj(1 / (1j * omega))), 0.5 * omega**2 * lost,
            unit="W s4/m2", tolerance=1e-6, case="Power balance of base motion",
            source="losses of structure and damper",
        )  # fmt: skip
