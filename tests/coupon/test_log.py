"""Output of LIGGGHTS: the numbers that were written, or a failure by its name."""

from pathlib import Path

import numpy as np
import pytest

from pidpanel.coupon import contact, log

GOLDEN = Path(__file__).parent / "golden"
STEPS, CYCLES, ATOMS = 1000, 12, 8
WHOLE = (GOLDEN / "shake" / "cycles.txt").read_text()
LOG = (GOLDEN / "shake" / "shake.log").read_text()


def read(text, cycles=CYCLES):
    return log.read_cycles(text, "cycles.txt", steps_per_cycle=STEPS, cycles=cycles)


def check(text):
    log.check_log(text, "shake.log", last_step=STEPS * CYCLES, atoms=ATOMS)


def test_a_whole_file_gives_the_numbers_that_stand_in_it():
    rows = read(WHOLE)
    assert rows.shape == (CYCLES, len(log.CYCLE_COLUMNS))
    reference = np.loadtxt(GOLDEN / "shake" / "cycles.txt")  # numpy's own reader skips '#'
    np.testing.assert_array_equal(rows, reference)


def test_a_whole_log_is_accepted():
    check(LOG)


def test_a_file_cut_at_any_line_is_refused():
    lines = WHOLE.splitlines(keepends=True)
    for kept in range(len(lines)):
        with pytest.raises(log.LogTruncated):
            read("".join(lines[:kept]))


def test_a_file_cut_at_any_byte_is_refused():
    for kept in range(len(WHOLE)):
        with pytest.raises(log.SolverFailure):
            read(WHOLE[:kept])


@pytest.mark.parametrize("word", ["nan", "inf", "-nan", "1e999", "3.1.4"])
def test_a_number_that_is_none_is_refused_with_its_line(word):
    lines = WHOLE.splitlines()
    fields = lines[4].split(" ")
    fields[2] = word
    lines[4] = " ".join(fields)
    with pytest.raises(log.NotFinite, match=r"cycles.txt:5: "):
        read("\n".join(lines) + "\n")


def test_a_missing_row_is_refused_with_the_step_that_should_stand_there():
    lines = WHOLE.splitlines()
    del lines[5]
    with pytest.raises(log.LogTruncated, match="step 5000 where 4000 should stand"):
        read("\n".join(lines) + "\n")


def test_a_doubled_row_is_refused():
    lines = WHOLE.splitlines()
    lines.insert(6, lines[6])
    with pytest.raises(log.LogTruncated, match="should stand"):
        read("\n".join(lines) + "\n")


def test_one_cycle_less_than_asked_for_is_refused():
    with pytest.raises(log.LogTruncated, match="12 of 13 cycles"):
        read(WHOLE, cycles=13)


def test_warnings_between_table_rows_do_no_harm():
    assert "WARNING" not in LOG
    lines = LOG.splitlines()
    row = next(i for i, line in enumerate(lines) if line.split()[:1] == ["3000"])
    lines.insert(row, "WARNING: time-step is 35.458742 % of rayleigh time (./src/fix.cpp:200)")
    check("\n".join(lines) + "\n")


def test_a_run_ended_by_sigterm_is_named_though_it_exited_0():
    text = (GOLDEN / "stopped_by_sigterm" / "shake.log").read_text()
    assert "3000000 steps" in text  # what its footer claims
    with pytest.raises(log.RunStopped, match="Forced restart written"):
        log.check_log(text, "shake.log", last_step=3000000, atoms=ATOMS)
    rows = (GOLDEN / "stopped_by_sigterm" / "cycles.txt").read_text()
    with pytest.raises(log.LogTruncated, match="of 3000 cycles"):
        log.read_cycles(rows, "cycles.txt", steps_per_cycle=STEPS, cycles=3000)


def test_a_run_ended_by_sigkill_is_named():
    text = (GOLDEN / "stopped_by_sigkill" / "shake.log").read_text()
    with pytest.raises(log.RunStopped, match="last mark at step 0, not 3000000"):
        log.check_log(text, "shake.log", last_step=3000000, atoms=ATOMS)


def test_lost_spheres_are_named():
    lines = LOG.splitlines()
    lines.append("ERROR: Lost atoms: original 8 current 7 (./src/thermo.cpp:439)")
    with pytest.raises(log.ParticlesLost, match="Lost atoms"):
        check("\n".join(lines))


def test_a_mark_with_fewer_spheres_is_named():
    with pytest.raises(log.ParticlesLost, match="7 spheres of 8"):
        check(
            LOG.replace(
                f"MARK step {STEPS * CYCLES} atoms 8", f"MARK step {STEPS * CYCLES} atoms 7"
            )
        )


def test_too_few_insertions_are_named():
    with pytest.raises(log.ParticlesLost, match="Less insertions"):
        check(LOG + "WARNING: Particle insertion: Less insertions than requested\n")


def test_a_log_without_any_mark_is_refused():
    with pytest.raises(log.LogTruncated, match="no mark"):
        check("LIGGGHTS (Version LIGGGHTS-PUBLIC 3.8.0)\n")


def test_the_echo_of_a_mark_is_not_taken_for_the_mark():
    text = "\n".join(line for line in LOG.splitlines() if not line.startswith("MARK"))
    assert 'print "MARK' in text
    with pytest.raises(log.LogTruncated, match="no mark"):
        check(text)


def test_positions_are_those_of_the_dump_by_id():
    text = (GOLDEN / "shake" / "last.dump").read_text()
    columns = ("x", "y", "z", "vx", "vy", "vz")
    frame = log.read_dump(text, "last.dump", columns)
    assert frame.shape == (1, ATOMS, 6)
    third = next(line for line in text.splitlines() if line.startswith("3 "))
    np.testing.assert_array_equal(frame[0, 2], [float(v) for v in third.split()[1:]])


def test_a_dump_cut_anywhere_is_refused():
    text = (GOLDEN / "shake" / "last.dump").read_text()
    for kept in range(len(text)):
        with pytest.raises(log.SolverFailure):
            log.read_dump(text[:kept], "last.dump", ("x", "y", "z", "vx", "vy", "vz"))


def test_our_rayleigh_time_is_the_solvers():
    # fix check/timestep/gran prints the step over its own Rayleigh time, f_check[1]
    row = next(line for line in LOG.splitlines() if line.split()[:1] == ["3000"])
    printed = float(row.split()[-2])
    ours = 5e-6 / contact.rayleigh_time(1.25e-3, 1190.0, 5e7, 0.35)
    assert ours == pytest.approx(printed, rel=1e-6)  # eight digits are printed
