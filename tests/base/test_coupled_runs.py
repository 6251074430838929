"""Panel and particles in one time integration on moving supports, against the solver."""

from types import SimpleNamespace

import numpy as np
import pytest
from moving import APPARENT, RATIO, WHITE

from pidpanel.coupled import force_record
from pidpanel.coupled.excited_panel import ExcitedPanel
from pidpanel.coupled.integration import Integration, drift_free_velocity
from pidpanel.coupled.scenario import CoupledScenario, RunSettings, SimulatedPatch
from pidpanel.damping_ratio import DampingRatio
from pidpanel.solve.layout import AttachedDamper, DamperLayout, layouts
from pidpanel.solve.panel import ModalPanel

LOW, HIGH, PERIOD, SETTLED, STATIONS = 30.0, 395.0, 2.0, 1.0, 32
ROWS = int(10 * HIGH * PERIOD)
INTERVALS = 6


class DeadWeights:
    """Masses [kg] on springs of 4 kHz in the cells: 1 % heavier at 400 Hz, 0.03 % at 65 Hz."""

    def __init__(self, mass, step):
        self.mass, self.step = mass, step
        self.stiffness = mass * (2 * np.pi * 4000.0) ** 2
        self.damping = 0.1 * np.sqrt(self.stiffness * mass)
        self.place, self.speed, self.force = np.zeros((3, mass.size))

    def wall_force(self):
        return self.force

    def advance(self, kick, substeps):
        self.speed = self.speed + kick
        before, half = self.speed, self.step / 2
        middle = self.speed + half * self.force / np.maximum(self.mass, 1e-300)
        self.place = self.place + self.step * middle
        self.force = -self.stiffness * self.place - self.damping * middle
        self.speed = middle + half * self.force / np.maximum(self.mass, 1e-300)
        return self.mass * (self.speed - before)


@pytest.fixture(scope="module")
def coupled(panel):
    """The panel with its patch, its settings, and what draws its forces."""
    ratio = DampingRatio((RATIO,))
    settings = RunSettings((LOW, HIGH), ratio, 343.0, PERIOD, SETTLED, STATIONS, STATIONS, None, {})
    excited = ExcitedPanel(
        settings, panel.basis, panel.plate, panel.supported.vectors, panel.excitation, None
    )
    bed = SimpleNamespace(packing=SimpleNamespace(cell_area=0.08 / STATIONS))
    patch = SimulatedPatch("PID-1", 1e9, (bed,))
    return excited.with_patches(CoupledScenario("mass", 1.0, (patch,), {}))


def recorded(coupled, mass):
    """Mean squares of the absolute accelerations of the points, and the balance."""
    interval = PERIOD / ROWS
    first = int(np.ceil(LOW * PERIOD))
    frequency = np.arange(first, int(HIGH * PERIOD) + 1) / PERIOD
    amplitude = force_record.draw_modal_force(
        frequency, coupled.excitation, np.array([LOW, HIGH]), np.random.default_rng(3)
    )
    joined = amplitude * force_record.before_hold(frequency, interval)[:, None]
    force = force_record.samples(joined, first, ROWS)
    settled = round(SETTLED / interval)
    bare = amplitude * np.exp(-2j * np.pi * frequency * settled * interval)[:, None]
    bare = bare / coupled.modal.dynamic_stiffness(frequency)
    modal, area = coupled.modal, coupled.area
    run = Integration(
        modal, coupled.at_cells, coupled.points, area, area, force[np.arange(-settled, ROWS + 1) % ROWS], interval / INTERVALS, 1,
        INTERVALS, settled,
    )  # fmt: skip
    start = np.stack([bare.real.sum(axis=0), (2j * np.pi * frequency @ bare).real])
    free = modal.angular_frequency == 0
    start[1, free] = drift_free_velocity(
        run.force[: ROWS + 1, free], modal.modal_mass[free], run.interval, INTERVALS
    )
    weights = DeadWeights(mass * area, run.interval)
    rows, state = run.advance([weights], run.begin(start), run.rows)
    tones = np.fft.rfft(rows.at_points[settled:], axis=0)[first : first + len(frequency)]
    tones = tones * (2 * np.pi * frequency[:, None]) ** 2 / (ROWS / 2)
    return np.sum(np.abs(tones) ** 2, axis=0) / 2, run.balance(state)


def solved(panel, mass):
    """The same by the solver, at the tones of the record."""
    f = np.arange(int(np.ceil(LOW * PERIOD)), int(HIGH * PERIOD) + 1) / PERIOD
    modal = ModalPanel(panel.modal, panel.patches, f, panel.observed[:-1, :1], f)
    load = AttachedDamper(0, lambda f, _gamma: (0 * f, 0 * f + mass, f > 0), False)
    (answer,) = layouts(modal, panel.excitation, [DamperLayout((load,) if mass else ())])
    return answer.response.acceleration_psd.sum(axis=0) / PERIOD


def test_the_table_moves_as_the_input_asks(coupled):
    frequency = np.arange(60, 790) / PERIOD
    drawn = force_record.draw_modal_force(
        frequency, coupled.excitation, np.array([LOW, HIGH]), np.random.default_rng(1)
    )
    acceleration = drawn[:, -1] / coupled.modal.modal_mass[-1]
    np.testing.assert_allclose(np.abs(acceleration) ** 2, 2 * WHITE / PERIOD)
    # all shapes are driven together
    np.testing.assert_allclose(
        drawn / acceleration[:, None], coupled.excitation.factors(frequency)[:, :, 0], rtol=1e-9
    )


@pytest.mark.slow
@pytest.mark.parametrize(("mass", "tolerance"), [(0.0, 2e-3), (APPARENT, 1.5e-2)])
def test_a_run_with_dead_weight_is_the_response_to_base_motion(panel, coupled, mass, tolerance):
    # the weights are 1 % heavier than that near 400 Hz
    squares, balance = recorded(coupled, mass)
    np.testing.assert_allclose(squares, solved(panel, mass), rtol=tolerance)
    assert abs(balance.error) < 1e-2
    assert abs(balance.particles) < 0.01 * balance.excitation
