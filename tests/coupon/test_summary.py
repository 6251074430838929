"""From a recorded run to its row, and when a table is refused."""

import math
import re
import shutil
from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from pidpanel.coupon import cycles, records, rows, summary
from pidpanel.coupon.balance import EnergyBalance
from pidpanel.coupon.liggghts.failures import RecordUnreadable
from pidpanel.coupon.records import CaseOutcome, MeasuredBalance, Outcome, Shaken
from tests.coupons import small_cases

GOLDEN = Path(__file__).parent / "liggghts" / "golden" / "shake"
MASS = 8 * 1190 * math.pi / 6 * 2.5e-3**3
LOSSES = EnergyBalance(10e-6, 0.0, 0.0, 0.0, 1e-6, 2e-6, 3e-6, 4e-6, 0.0)


def recorded_case(**sweep):
    """The case of which the golden rows are: twelve cycles of eight spheres."""
    return small_cases(sweep=sweep, accuracy={"seeds": 1})


def record(case, folder, *, status="ok", closure=0.001, energies=None):
    """Leave the golden rows as the run of a case."""
    (home,) = case.folders(folder)
    home.mkdir(parents=True)
    shutil.copy(GOLDEN / "cycles_1.txt", home)
    balance = MeasuredBalance(energies or LOSSES, closure, 1, 100)
    found = Shaken(12, (12,), 8, MASS, "accuracy", balance)
    if status != "ok":
        found = None
    outcome = Outcome(status, "so it says", found)
    records.write(case.outcome_file(folder), CaseOutcome((outcome,)))


def read(case, folder):
    """Estimates of the one run of a case, and its folder."""
    (outcome,) = records.read(CaseOutcome, case.outcome_file(folder)).runs
    (home,) = case.folders(folder)
    return summary.read_run(case.point, outcome.product, home), home


def test_a_row_is_what_the_recorded_momentum_says(tmp_path):
    (case,) = recorded_case()
    record(case, tmp_path)
    row = summary.summarise(case, *summary.read_seeds(case, tmp_path))
    p_sin = np.loadtxt(GOLDEN / "cycles_1.txt")[:, 1]
    area, omega = math.sqrt(3) / 2 * 6.35e-3**2, 2 * math.pi * 200
    amplitude = 98.0665 / omega**2
    start = 12 - row["cycles_used"]
    damping = 2 * p_sin[start:].mean() / (amplitude * area)
    assert row["equivalent_damping_n_s_m3"] == pytest.approx(damping, rel=1e-9)
    assert row["dissipated_energy_j_m2"] == pytest.approx(
        math.pi * damping * omega * amplitude**2, rel=1e-9
    )
    assert row["particle_mass_per_area_kg_m2"] == pytest.approx(MASS / area)
    assert row["spheres_per_cell"] == 8
    assert row["acceleration_g"] == pytest.approx(10)
    assert row["displacement_mm"] == pytest.approx(1e3 * amplitude)
    assert row["bound_n_s_m3"] == pytest.approx(cycles.inelastic_bound(MASS / area, 200.0))
    assert (row["normal_share"], row["tangential_share"], row["wall_share"]) == pytest.approx(
        (0.4, 0.6, 0.7)
    )
    assert row["closure"] == 0.001


def test_an_apparent_mass_without_an_error_is_known_to_the_mass_of_the_particles(tmp_path):
    (case,) = recorded_case()
    record(case, tmp_path)
    ((seed,), problems) = summary.read_seeds(case, tmp_path)
    unknown = replace(seed, apparent_mass=replace(seed.apparent_mass, error=math.inf))
    row = summary.summarise(case, [unknown], problems)
    area = math.sqrt(3) / 2 * 6.35e-3**2
    assert row["apparent_mass_error_kg_m2"] == pytest.approx(MASS / area)


@pytest.mark.parametrize(
    ("spoil", "status", "message"),
    [
        (lambda file: file.write_text("# cut"), "LogTruncated", "cut"),
        (lambda file: file.unlink(), "LogTruncated", "no such file"),
    ],
)
def test_what_cannot_be_read_of_a_run_is_its_status(tmp_path, spoil, status, message):
    (case,) = recorded_case()
    record(case, tmp_path)
    spoil(case.folders(tmp_path)[0] / "cycles_1.txt")
    row = summary.summarise(case, *summary.read_seeds(case, tmp_path))
    assert row["status"] == status
    assert message in row["message"] and str(tmp_path) in row["message"]
    assert math.isnan(row["equivalent_damping_n_s_m3"])


def test_an_energy_that_does_not_close_is_named_and_its_value_kept(tmp_path):
    (case,) = recorded_case()
    record(case, tmp_path, closure=-0.021)
    found, home = read(case, tmp_path)
    problems = list(summary.find_problems(case.point, found, home))
    assert "EnergyNotClosed" in [type(problem).__name__ for problem in problems]
    assert any("-2.10% of the work is missing" in str(problem) for problem in problems)
    assert (
        summary.summarise(case, *summary.read_seeds(case, tmp_path))["equivalent_damping_n_s_m3"]
        > 0
    )


def problems(folder, **changes):
    """Names of what speaks against the golden run with other energies than in its balance."""
    (case,) = recorded_case()
    record(case, folder, **changes)
    found = list(summary.find_problems(case.point, *read(case, folder)))
    return [type(problem).__name__ for problem in found]


def test_a_closure_that_is_no_number_is_not_closed(tmp_path):
    assert "EnergyNotClosed" in problems(tmp_path, closure=math.nan)


def test_losses_of_the_contacts_are_of_the_size_of_those_of_the_rows(tmp_path):
    # the golden rows: 12 cycles, whose work is known
    p_sin = np.loadtxt(GOLDEN / "cycles_1.txt")[:, 1]
    work = float(98.0665 * p_sin[4:].mean() / 200)

    def balance(lost, given=work):
        return EnergyBalance(given, 0.0, 0.0, 0.0, lost, 0.0, 0.0, 0.0, 0.0)

    for name, energies, wrong in (
        ("as large", balance(work), False),
        ("ten times", balance(10 * work), False),
        ("a cycle in flight", balance(0.01 * work), False),
        ("in milli", balance(1e3 * work), True),
        ("fifty times", balance(50 * work), True),
        ("the wrong sign", balance(-work), True),
        ("work in milli", balance(work, 1e3 * work), True),
        ("work of the wrong sign", balance(work, -30 * work), True),
    ):
        found = problems(tmp_path / name, energies=energies)
        assert ("LossesApart" in found) == wrong, name


def table_of(*statuses):
    return [{"case": f"c{i}", "status": s, "message": "m"} for i, s in enumerate(statuses)]


def test_a_table_of_too_few_good_cases_is_refused_with_the_others_named():
    table = table_of("ok", "ok", "ok", "NotSteady")
    summary.check_coverage(table, 0.75)
    with pytest.raises(summary.CoverageMissed, match=r"c3: NotSteady: m\n75.0%.*requires 76.0%"):
        summary.check_coverage(table, 0.76)


def test_a_table_is_written_before_it_is_refused(tmp_path):
    one, other = recorded_case(acceleration_g=[10, 12])
    record(one, tmp_path, status="NotSteady")
    record(other, tmp_path, status="NotSteady")
    table = tmp_path / "cases.csv"
    with pytest.raises(summary.CoverageMissed, match="NotSteady: so it says"):
        summary.write_table([one, other], tmp_path, table, coverage=0.5)
    rows = table.read_text().splitlines()  # to be looked at
    assert [line.split(",")[0] for line in rows] == ["case", one.label, other.label]


def test_a_run_that_drifts_counts_with_the_error_that_says_so(tmp_path):
    # halves that differ by five errors of their difference: the mean may be off by half of that
    (case,) = recorded_case()
    record(case, tmp_path)
    found, _ = read(case, tmp_path)
    for drift, times in ((1.0, 1.0), (-5.0, 5.0)):
        damping = replace(found.damping, start=0, drift=drift)
        assert summary.total_damping_error(replace(found, damping=damping)) == pytest.approx(
            times * damping.error
        )
    late = replace(found.damping, start=11, drift=0.5)  # not steady, though it drifts little
    assert summary.total_damping_error(replace(found, damping=late)) == late.error


def test_runs_that_are_not_steady_count_by_their_error():
    """Sixty cycles of noise with memory, on which a transient of fifteen dies away."""
    rng, count, memory = np.random.default_rng(0), 60, 0.3
    transient = 0.5 * np.exp(-np.arange(count) / 15)
    off = []
    for _ in range(300):
        drawn = rng.standard_normal(count + 20)
        noise = np.convolve(drawn, memory ** np.arange(20))[20 : 20 + count]
        series = 1 + 0.15 * noise + transient * rng.choice([-1, 1])
        found = cycles.estimate(series)
        if not rows.is_steady(found, count):
            read = SimpleNamespace(damping=found, shaken=SimpleNamespace(cycles=count))
            off.append((found.mean - 1) / summary.total_damping_error(read))
    assert len(off) > 40
    assert np.sqrt(np.mean(np.square(off))) < 1.6  # 1.8 without what they drift
    assert np.mean(np.abs(off) < 2) > 0.75


@pytest.mark.parametrize("spoil", [lambda file: file.unlink(), lambda file: file.write_text("{}")])
def test_an_outcome_that_cannot_be_read_is_an_error_that_names_its_file(tmp_path, spoil):
    (case,) = recorded_case()
    record(case, tmp_path)
    spoil(case.outcome_file(tmp_path))
    with pytest.raises(RecordUnreadable, match=re.escape(str(case.outcome_file(tmp_path)))):
        summary.read_seeds(case, tmp_path)
