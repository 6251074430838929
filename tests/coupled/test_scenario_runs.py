"""A run is drawn from the excitation of its scenario and judged by its energies."""

from dataclasses import replace

import numpy as np
import pytest
import xarray as xr

from pidpanel.coupled.checkpoints import Checkpoint
from pidpanel.coupled.integration import Rows
from pidpanel.coupled.pieces import run_identity
from pidpanel.coupled.scenario import CoupledScenario, SimulatedPatch
from pidpanel.coupled.scenario_runs import ScenarioRuns, _steps
from pidpanel.coupon import records
from pidpanel.coupon.liggghts.deck import WALLS_FILE
from pidpanel.coupon.liggghts.failures import EnergyNotClosed
from pidpanel.coupon.preparation import BED_FILE
from pidpanel.coupon.records import OK, Loosened, Outcome
from pidpanel.solve.base_motion import BaseExcitation, inertia_of, with_translation
from tests.beds import hexagons

DURATION, SETTLING = 0.5043, 0.031
ROWS = 757  # 10 × 150 Hz × 0.5043 s = 756.45
INTERVAL = DURATION / ROWS
SETTLED = 47
SPHERES = {2.5: 3, 1.0: 20}
"""Of each cell, by their diameter [mm]."""


def stored(found, folder, spheres):
    """Write a bed of so many spheres in each cell, all at its centre."""
    folder.mkdir(parents=True)
    centres, size = found.packing.centres, found.packing.diameter
    rows = [[*centre, size / 2, size] for centre in centres.tolist() for _ in range(spheres)]
    np.savetxt(folder / BED_FILE, rows, delimiter=",", header="x_m,y_m,z_m,diameter_m")
    (folder / WALLS_FILE).write_text("solid walls\nendsolid\n")
    records.write(folder / "bed.json", Outcome(OK, "", Loosened(len(rows), 0.0)))


@pytest.fixture
def runs(excited, tmp_path):
    """Two runs of a patch with spheres of 2.5 mm and one with spheres of 1 mm."""
    patches = []
    for name, diameter in (("middle", 2.5), ("side", 1.0)):
        # the second run has one sphere more in a cell
        beds = tuple(hexagons(3300, diameter, seed) for seed in (1, 2))
        for extra, one in enumerate(beds):
            stored(one, tmp_path / "bed" / one.label, SPHERES[diameter] + extra)
        patches.append(SimulatedPatch(name, 3.3e9, beds))
    scenario = CoupledScenario("one", 1e5, tuple(patches), {})
    return ScenarioRuns(excited, scenario, tmp_path, tmp_path / "records")


def test_tones_fill_the_range_with_a_common_period(runs):
    # k/period from 20.2 to 75.6 Hz periods
    drawn = runs.drawn(1)
    number = drawn.frequency * DURATION
    assert number == pytest.approx(np.arange(21, 76))
    assert drawn.first == 21


def test_the_forces_are_those_of_the_tones_and_repeat(runs):
    # joined linearly: over a period from row `settled` on their harmonics are the amplitudes
    drawn = runs.drawn(1)
    run = drawn.integration
    assert run.force[: SETTLED + 1] == pytest.approx(run.force[ROWS:], abs=1e-9)
    fine = 40
    time = (np.arange(ROWS * fine) + 0.5) / fine
    period = run.force[SETTLED:, 0]
    joined = np.interp(time, np.arange(ROWS + 1), period)
    phase = 2 * np.pi * np.outer(drawn.frequency, time * INTERVAL)
    harmonic = 2 * np.mean(joined * np.exp(-1j * phase), axis=1)
    size = np.abs(drawn.amplitude[:, 0])
    assert np.abs(harmonic - drawn.amplitude[:, 0]).max() < 2e-3 * size.max()


def test_a_run_starts_in_the_motion_of_the_bare_panel(runs):
    # Re Σ X e^{iωt}/Z₀ at the first row, its slope by differences
    drawn = runs.drawn(1)
    modal = runs.panel.modal
    omega, own = 2 * np.pi * drawn.frequency[:, None], 2 * np.pi * modal.natural_frequency
    stiffness = modal.modal_mass * (own**2 - omega**2 + 2j * modal.damping_ratio * own * omega)

    def at(time):
        return (drawn.amplitude / stiffness * np.exp(1j * omega * time)).real.sum(axis=0)

    start = -SETTLED * INTERVAL
    assert drawn.start[0] == pytest.approx(at(start), rel=1e-9)
    slope = (at(start + 1e-6) - at(start - 1e-6)) / 2e-6
    assert drawn.start[1] == pytest.approx(slope, rel=1e-4, abs=1e-6 * np.abs(slope).max())


class Nothing:
    """Cells without particles."""

    def __init__(self, cells):
        self.none = np.zeros(cells)

    def wall_force(self):
        return self.none

    def advance(self, kick, substeps):
        return self.none


def test_a_table_that_nothing_holds_is_where_it_was_after_a_period(runs):
    # as are all other shapes, but for the steps of the integration
    excited = runs.excited
    inertia = inertia_of(excited.basis, excited.plate, excited.vectors, 6.0)
    moved = replace(
        excited,
        basis=with_translation(excited.basis, inertia),
        excitation=BaseExcitation.of_inertia(lambda f: np.full(f.shape, 2.0), inertia),
    )
    drawn = replace(runs, excited=moved).drawn(1)
    run = drawn.integration
    cells = [Nothing(len(run.patch_area))]
    begin = run.begin(drawn.start)
    first, state = run.advance(cells, begin, 1)
    rows, state = run.advance(cells, state, ROWS)
    rest, _ = run.advance(cells, state, ROWS + 1)
    apart = state.shapes - begin.shapes
    reach = np.abs(np.concatenate([first.at_points, rows.at_points])).max()
    assert np.abs(apart[0, -1]) < 1e-9 * reach
    assert np.abs(apart[0]).max() < 2e-3 * reach
    assert np.abs(rest.at_points - first.at_points).max() < 5e-3 * reach


def test_every_run_has_beds_and_forces_of_its_own(runs):
    first, second = runs.drawn(1), runs.drawn(2)
    for number, drawn in ((0, first), (1, second)):
        labels = [patch.beds[number].label for patch in runs.scenario.patches]
        assert [started.folder.name for started in drawn.beds] == labels
        assert [started.spheres for started in drawn.beds] == [8 * (3 + number), 8 * (20 + number)]
    assert np.abs(first.amplitude / second.amplitude - 1).max() > 0.1
    # and another scenario has others
    other = replace(runs, scenario=replace(runs.scenario, name="two")).drawn(1)
    assert np.abs(first.amplitude / other.amplitude - 1).max() > 0.1


def test_what_the_beds_weigh(runs):
    # on hexagons of 6.35 mm across flats
    area = np.sqrt(3) / 2 * 6.35e-3**2
    for number in (1, 2):
        counts = np.array([3, 20]) + number - 1
        wanted = counts * 1190 * np.pi / 6 * np.array([2.5e-3, 1e-3]) ** 3 / area
        assert runs.masses(number) == pytest.approx(wanted, rel=1e-9)


def finished(runs, missing):
    """Leave the last checkpoint of a run 1, of whose energy a share is missing."""
    drawn = runs.drawn(1)
    run, cells = drawn.integration, len(runs.panel.at_cells)
    rng = np.random.default_rng(1)
    rows = Rows(*(rng.standard_normal((run.rows, n)) for n in (cells, 2, cells)))
    supplied, particles = 2.0, 0.6
    lost = 2.0 * (1 - missing) - particles
    state = run.begin(0 * drawn.start)._replace(
        row=run.rows,
        energies=np.array([2 * particles, supplied / run.intervals_per_row, lost / INTERVAL, 0.0]),
    )
    folder = runs.folder / "run1"
    folder.mkdir(parents=True)
    Checkpoint((rows,), state).write(folder, run_identity(run, drawn.start, drawn.beds))
    return rows


def test_a_run_that_is_through_is_recorded_with_its_shares(runs):
    rows = finished(runs, 0.0095)
    found = runs.record(1)
    assert found.at_points == pytest.approx(rows.at_points, rel=1e-6)
    assert (found.rows, found.settled, found.first) == (ROWS + SETTLED, SETTLED, 21)
    cell_area = runs.panel.patches[0].cell_area
    assert found.impulse == pytest.approx(rows.impulse / cell_area)
    with xr.open_dataset(runs.folder / "run1.nc", engine="scipy") as data:
        attributes = dict(data.attrs)
    assert attributes["share_of_particles"] == pytest.approx(0.3)
    assert attributes["balance_error"] == pytest.approx(0.0095)
    assert attributes["study"] == "mine"
    assert attributes["mass_per_area_kg_m2"] == pytest.approx(runs.masses(1))
    assert not (runs.folder / "run1").exists()
    again = runs.record(1)
    assert np.array_equal(again.impulse, found.impulse)


@pytest.mark.parametrize("missing", [0.0105, -0.0105, np.nan])
def test_a_run_that_loses_energy_is_refused(runs, missing):
    # more than a hundredth
    finished(runs, missing)
    with pytest.raises(EnergyNotClosed, match="allowed is 1 %"):
        runs.record(1)


def test_an_interval_is_a_whole_number_of_steps_that_fit():
    # of 1.5 and 2.5 of the longest steps: one and two
    assert _steps(50e-6, 8e-6 / 1.5, 8e-6) == (10, 1)
    assert _steps(50e-6, 3.2e-6, 8e-6) == (8, 2)
