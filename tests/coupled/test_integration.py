"""Panel and particles together do what the closed form says, and lose neither energy nor momentum."""

import functools

import numpy as np
import pytest

from pidpanel.coupled.force_record import before_hold, samples
from pidpanel.coupled.integration import Balance, Integration, Rows
from pidpanel.coupled.linear import linear_motion
from pidpanel.coupled.spectra import band_sums
from pidpanel.solve.bands import third_octaves
from pidpanel.solve.model import ModalBasis

STEP, INTERVALS, ROWS = 1e-5, 8, 3000
LOW, HIGH = 30.0, 800.0


def run(plate, particles, impedance, cell_area=None, intervals=INTERVALS, substeps=1):
    """Record and closed form, both from their steady state, of a record of 0.24 s."""
    row = INTERVALS * STEP
    time = ROWS * row
    first = int(np.ceil(LOW * time))
    frequency = np.arange(first, int(HIGH * time) + 1) / time
    rng = np.random.default_rng(7)
    size = (len(frequency), plate.count)
    amplitude = rng.standard_normal(size) + 1j * rng.standard_normal(size)
    cells = plate.at_cells
    seen = np.concatenate([cells, plate.at_points, np.eye(plate.count)])
    exact = linear_motion(
        frequency, plate.modal, None, cells.T, seen, impedance(frequency), amplitude
    )
    omega = 2j * np.pi * frequency[:, None]
    q = exact[:, len(cells) + 2 :]
    start = np.stack([q.real.sum(axis=0), (omega * q).real.sum(axis=0)])
    spring = particles.stiffness + omega * particles.damping
    place = -(omega**2) * particles.mass / (spring + omega**2 * particles.mass)
    place = place * exact[:, : len(cells)]
    particles.place = place.real.sum(axis=0)
    particles.speed = (omega * place).real.sum(axis=0)
    particles.force = -particles.stiffness * particles.place - particles.damping * particles.speed
    force = samples(amplitude * before_hold(frequency, row)[:, None], first, ROWS)
    whole = Integration(
        plate.modal,
        plate.at_cells,
        plate.at_points,
        plate.area,
        plate.area if cell_area is None else cell_area,
        np.concatenate([force, force[:1]]),
        row / (intervals * substeps),
        substeps,
        intervals,
        0,
    )
    record = plate.recorded(whole, *whole.advance([particles], whole.begin(start), whole.rows))
    spectrum = np.fft.rfft(record.at_points, axis=0)[first : first + len(frequency)] / (ROWS / 2)
    return frequency, spectrum, exact[:, len(cells) : len(cells) + 2], record


def decibels(frequency, found, wanted):
    _, edge = third_octaves(40.0, 700.0)
    squares = [
        band_sums(frequency, frequency[:, None] ** 4 * np.abs(values) ** 2, edge)
        for values in (found, wanted)
    ]
    return 10 * np.log10(squares[0] / squares[1])


@pytest.mark.slow
def test_without_particles_the_panel_does_what_the_closed_form_says(plate, oscillators):
    # 0.05 dB a third octave is asked for; ten rows a period of the highest tone leave 0.005
    none = oscillators(np.full(8, 1e-15), np.full(8, 1e-12), np.zeros(8), STEP)
    found = run(plate, none, lambda f: np.zeros((len(f), 8)))
    assert np.abs(decibels(*found[:3])).max() < 0.02
    assert abs(found[3].balance.error) < 1e-3


def mass(oscillators, step=STEP):
    # 6 kg/m², heavier than the panel, on springs of 8 kHz: coupling through the force of the
    # step before would be unstable
    kilograms = np.full(8, 6.0 * 0.01)
    stiffness = kilograms * (2 * np.pi * 8000.0) ** 2
    return oscillators(kilograms, stiffness, 0.02 * np.sqrt(stiffness * kilograms), step)


def dashpot(oscillators, step=STEP):
    # 1000 N s/m³ against masses that stay where they are
    kilograms = np.full(8, 60.0 * 0.01)
    return oscillators(kilograms, kilograms * (2 * np.pi * 3) ** 2, np.full(8, 10.0), step)


@pytest.fixture(scope="module")
def shaken(plate, oscillators):
    """(stand-in, substeps, intervals) → the outcome of `run`, computed once."""

    @functools.cache
    def outcome(stand_in, substeps=1, intervals=INTERVALS):
        particles = stand_in(oscillators, INTERVALS / intervals * STEP / substeps)
        return run(plate, particles, particles.impedance, intervals=intervals, substeps=substeps)

    return outcome


@pytest.mark.slow
@pytest.mark.parametrize("substeps", [1, 4])
@pytest.mark.parametrize("stand_in", [mass, dashpot])
def test_particles_in_closed_form_change_the_panel_as_their_impedance_says(
    shaken, stand_in, substeps
):
    # what is left is of first order in the step: a force from the speed of the step's middle
    found = shaken(stand_in, substeps)
    assert np.abs(decibels(*found[:3])).max() < 0.05
    balance = found[3].balance
    share = balance.particles / balance.excitation
    assert share > 0.1 if stand_in is dashpot else abs(share) < 0.05
    # allowed is 1 % in a run
    assert abs(balance.error) < 2e-3


@pytest.mark.slow
def test_the_difference_falls_with_the_interval(shaken):
    errors = []
    for intervals in (INTERVALS, 2 * INTERVALS):
        _, found, wanted, _ = shaken(dashpot, 1, intervals)
        errors.append(np.linalg.norm(found - wanted) / np.linalg.norm(wanted))
    assert errors[0] < 0.002
    assert 1.8 < errors[0] / errors[1] < 4.5


class Ball:
    """A ball in one cell, pushed back by a stiff floor below it."""

    def __init__(self, mass, stiffness, speed, time_step):
        self.mass, self.stiffness, self.time_step = mass, stiffness, time_step
        self.place, self.speed = np.array([1e-4]), np.array([speed])

    def wall_force(self):
        return self.stiffness * np.maximum(-self.place, 0.0)

    def advance(self, kick, substeps):
        self.speed = self.speed + kick
        before, half = self.speed, self.time_step / 2 / self.mass
        for _ in range(substeps):
            middle = self.speed + half * self.wall_force()
            self.place = self.place + self.time_step * middle
            self.speed = middle + half * self.wall_force()
        return self.mass * (self.speed - before)


@pytest.mark.parametrize("substeps", [1, 4])
def test_a_free_panel_and_a_ball_part_with_the_momentum_that_they_had(substeps):
    # a contact of twelve intervals whose force is a guess for half of each: none of it is lost
    panel_mass, ball_mass, speed = 3.0, 1.0, -2.0
    one = np.ones((1, 1))
    panel = ModalBasis([0.0], [panel_mass], [1e-3]), one, one
    reduced = 1 / (1 / panel_mass + 1 / ball_mass)
    ball = Ball(ball_mass, reduced * (np.pi / (12 * STEP)) ** 2, speed, STEP / substeps)
    rows = 20
    no_force = np.zeros((rows + 1, 1))
    area = np.array([0.01])
    parts = Integration(*panel, area, area, no_force, STEP / substeps, substeps, 4, 0)
    _, state = parts.advance([ball], parts.begin(np.zeros((2, 1))), rows)
    velocity = state.shapes[1, 0]
    assert ball.place[0] > 0  # they have parted
    momentum = panel_mass * velocity + ball_mass * (ball.speed[0] + velocity)
    assert momentum == pytest.approx(ball_mass * speed, rel=1e-12)
    # elastic: within the energy that the guesses make
    assert velocity == pytest.approx(2 * ball_mass * speed / (panel_mass + ball_mass), rel=0.02)


@pytest.mark.slow
def test_cells_stand_for_a_larger_area(shaken, plate, oscillators):
    # a tenth of the mass in a tenth of the area is the same damper
    part = dashpot(oscillators)
    for name in ("mass", "stiffness", "damping"):
        setattr(part, name, getattr(part, name) / 10)
    first = shaken(dashpot)
    other = run(plate, part, dashpot(oscillators).impedance, cell_area=plate.area / 10)
    assert other[1] == pytest.approx(first[1], rel=1e-9, abs=1e-12 * np.abs(first[1]).max())
    assert other[3].impulse == pytest.approx(first[3].impulse, rel=1e-9, abs=1e-9)
    # and takes the same energy
    for name in ("excitation", "modes", "particles", "gain"):
        value = getattr(first[3].balance, name)
        assert getattr(other[3].balance, name) == pytest.approx(value, rel=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("substeps", [1, 4])
def test_the_impulse_is_that_of_the_walls(shaken, substeps):
    # on a mass that follows the panel: its momentum per area
    record = shaken(mass, substeps)[3]
    speed = np.gradient(record.at_cells, record.interval, axis=0)[5:-5]
    momentum = 6.0 * speed
    found = record.impulse[5:-5] - record.impulse[5:-5].mean(axis=0)
    apart = found - (momentum - momentum.mean(axis=0))
    assert np.std(apart) < 0.03 * np.std(momentum)
    # no later and no earlier than a tenth of an interval
    slope = np.gradient(momentum, record.interval, axis=0)
    assert abs((apart * slope).sum() / (slope**2).sum()) < 0.1 * STEP


@pytest.mark.parametrize("substeps", [1, 4])
def test_in_pieces_a_run_is_the_same_to_the_bit(plate, oscillators, substeps):
    rng = np.random.default_rng(3)
    force = rng.standard_normal((31, plate.count))
    shapes = plate.modal, plate.at_cells, plate.at_points
    run = Integration(*shapes, plate.area, plate.area, force, STEP, substeps, 2, 12)
    records, start = [], rng.standard_normal((2, plate.count))
    for ends in ([30], [1, 12, 13, 30]):
        particles, pieces = dashpot(oscillators), []
        state = run.begin(start)
        for end in ends:
            piece, state = run.advance([particles], state, end)
            pieces.append(piece)
        records.append(plate.recorded(run, Rows.joined(pieces), state))
    whole, parts = records
    assert whole.balance == parts.balance
    for name in ("at_cells", "at_points", "impulse"):
        assert np.array_equal(getattr(whole, name), getattr(parts, name))


def test_the_error_is_the_share_of_the_energy_that_is_missing():
    assert Balance(excitation=20.0, modes=9.0, particles=6.0, gain=3.0).error == pytest.approx(0.1)
    assert Balance(excitation=20.0, modes=9.0, particles=6.0, gain=7.0).error == pytest.approx(-0.1)


def test_what_does_not_fit_is_refused(plate, oscillators):
    few = oscillators(np.ones(3), np.ones(3), np.zeros(3), STEP)
    shapes = plate.modal, plate.at_cells, plate.at_points
    of = (*shapes, plate.area, plate.area, np.zeros((3, plate.count)), STEP, 1)
    run = Integration(*of, 2, 0)
    with pytest.raises(ValueError, match="3 cells, the panel has 8"):
        run.advance([few], run.begin(np.zeros((2, plate.count))), 2)
    with pytest.raises(ValueError, match="must be even"):
        Integration(*of, 3, 0)
