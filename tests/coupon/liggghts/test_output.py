"""Output of LIGGGHTS: the numbers that were written, or a failure by its name."""

import re
from pathlib import Path

import numpy as np
import pytest

from pidpanel.coupon import contact
from pidpanel.coupon.liggghts import failures, output

GOLDEN = Path(__file__).parent / "golden"
STEPS, CYCLES, ATOMS = 1000, 12, 8
WHOLE = (GOLDEN / "shake" / "cycles_1.txt").read_text()
LOG = (GOLDEN / "shake" / "shake_1.log").read_text()


def read(text, cycles=CYCLES):
    return output.read_cycles(text, "cycles.txt", steps_per_cycle=STEPS, cycles=cycles)


def check(text):
    output.check_log(text, "shake.log", last_step=STEPS * (CYCLES + 1), atoms=ATOMS)


def test_a_whole_file_gives_the_numbers_that_stand_in_it():
    rows = read(WHOLE)
    assert rows.shape == (CYCLES, len(output.CYCLE_COLUMNS))
    reference = np.loadtxt(GOLDEN / "shake" / "cycles_1.txt")  # numpy's own reader skips '#'
    np.testing.assert_array_equal(rows, reference)


def test_a_file_cut_at_any_byte_is_refused():
    for kept in range(len(WHOLE)):
        with pytest.raises(failures.SolverFailure):
            read(WHOLE[:kept])


@pytest.mark.parametrize("word", ["nan", "inf", "-nan", "1e999", "3.1.4", "1_000", "１２", "0x1p3"])
def test_a_number_that_is_none_is_refused_with_its_line(word):
    lines = WHOLE.splitlines()
    fields = lines[4].split(" ")
    fields[2] = word
    lines[4] = " ".join(fields)
    with pytest.raises(failures.NotFinite, match=r"cycles.txt:5: "):
        read("\n".join(lines) + "\n")


def test_a_missing_row_is_refused_with_the_step_that_should_stand_there():
    lines = WHOLE.splitlines()
    del lines[5]
    with pytest.raises(failures.LogTruncated, match="step 5000 instead of 4000"):
        read("\n".join(lines) + "\n")


def test_one_cycle_less_than_asked_for_is_refused():
    with pytest.raises(failures.LogTruncated, match="12 of 13 cycles"):
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
    with pytest.raises(failures.RunStopped, match="Forced restart written"):
        output.check_log(text, "shake.log", last_step=3000000, atoms=ATOMS)
    rows = (GOLDEN / "stopped_by_sigterm" / "cycles.txt").read_text()
    with pytest.raises(failures.LogTruncated, match="of 3000 cycles"):
        output.read_cycles(rows, "cycles.txt", steps_per_cycle=STEPS, cycles=3000)


def test_a_run_ended_by_sigkill_is_named():
    text = (GOLDEN / "stopped_by_sigkill" / "shake.log").read_text()
    with pytest.raises(failures.RunStopped, match="last mark at step 0, not 3000000"):
        output.check_log(text, "shake.log", last_step=3000000, atoms=ATOMS)


MARKED = f"MARK step {STEPS * CYCLES} atoms"


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (f"{LOG}ERROR: Lost atoms: original 8 current 7 (./src/thermo.cpp:439)", "Lost atoms"),
        (f"{LOG}WARNING: Particle insertion: Less insertions than requested\n", "Less insertions"),
        (LOG.replace(f"{MARKED} 8", f"{MARKED} 7"), "7 spheres of 8"),
    ],
)
def test_lost_spheres_are_named(text, message):
    with pytest.raises(failures.ParticlesLost, match=message):
        check(text)


def test_the_echo_of_a_mark_is_not_taken_for_the_mark():
    text = "\n".join(line for line in LOG.splitlines() if not line.startswith("MARK"))
    assert 'print "MARK' in text
    with pytest.raises(failures.LogTruncated, match="no mark"):
        check(text)


def test_positions_are_those_of_the_dump_by_id():
    text = (GOLDEN / "shake" / "last.dump").read_text()
    columns = ("x", "y", "z", "vx", "vy", "vz")
    frame = output.read_dump(text, "last.dump", columns)
    assert frame.shape == (1, ATOMS, 6)
    third = next(line for line in text.splitlines() if line.startswith("3 "))
    np.testing.assert_array_equal(frame[0, 2], [float(v) for v in third.split()[1:]])


def test_a_dump_cut_anywhere_is_refused():
    text = (GOLDEN / "shake" / "last.dump").read_text()
    for kept in range(len(text)):
        with pytest.raises(failures.SolverFailure):
            output.read_dump(text[:kept], "last.dump", ("x", "y", "z", "vx", "vy", "vz"))


def test_our_rayleigh_time_is_the_solvers():
    # fix check/timestep/gran prints the step over its own Rayleigh time, f_check[1]
    row = next(line for line in LOG.splitlines() if line.split()[:1] == ["3000"])
    printed = float(row.split()[-2])
    ours = 5e-6 / contact.ElasticSphere(1.25e-3, 1190.0, 5e7, 0.35).rayleigh_time
    assert ours == pytest.approx(printed, rel=1e-6)  # eight digits are printed


# ------------------------------------------------------------------ dumps of the energy balance


def binary_frame(step, table):
    head = np.zeros(1, output._BINARY_HEADER)
    head["step"], head["atoms"], head["columns"] = step, len(table), table.shape[1]
    head["values"] = table.size
    return head.tobytes() + table.astype("<f8").tobytes()


TABLE = np.array([[1.0, 0.1, 0.2], [2.0, 0.3, 0.4]])


def test_a_binary_dump_is_read_frame_by_frame():
    content = binary_frame(5, TABLE) + binary_frame(9, 2 * TABLE - TABLE[:, :1] * [1, 0, 0])
    found = output.read_binary_dump(content, "spheres.bin", atoms=2, columns=3)
    assert found.shape == (2, 2, 3)
    np.testing.assert_array_equal(found[0], TABLE)


@pytest.mark.parametrize(
    ("content", "failure"),
    [
        (binary_frame(5, TABLE)[:-1], failures.LogTruncated),
        (b"", failures.LogTruncated),
        (binary_frame(5, TABLE) + binary_frame(5, TABLE), failures.LogTruncated),
        (binary_frame(5, TABLE * [1, np.nan, 1]), failures.NotFinite),
        (binary_frame(5, TABLE + 1), failures.ParticlesLost),
    ],
)
def test_a_binary_dump_that_is_not_whole_is_named(content, failure):
    with pytest.raises(failure, match=r"spheres\.bin"):
        output.read_binary_dump(content, "spheres.bin", atoms=2, columns=3)


LOCAL = (
    "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n2\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n"
    "ITEM: ENTRIES c_a[1] c_a[2] \n1 0.5 \n2 0.25 \n"
    "ITEM: TIMESTEP\n4\nITEM: NUMBER OF ENTRIES\n0\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n"
    "ITEM: ENTRIES c_a[1] c_a[2] \n"
    "ITEM: TIMESTEP\n8\nITEM: NUMBER OF ENTRIES\n1\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n"
    "ITEM: ENTRIES c_a[1] c_a[2] \n3 0.125 \n"
)


def frames_of(text):
    return output.read_frames(text, "pairs.dump", "ENTRIES", 2)


def test_contacts_are_read_with_their_frame_and_a_frame_may_have_none():
    counts, table = frames_of(LOCAL)
    assert counts == [2, 0, 1]
    assert table.tolist() == [[1, 0.5], [2, 0.25], [3, 0.125]]


def test_contacts_cut_anywhere_are_named():
    text = re.sub(r"^(\d) (0\.\d+) $", r"\1 2 \2 0 0 ", LOCAL, flags=re.MULTILINE)
    assert len(contacts(text, frames=3).first) == 3
    for end in range(len(text)):
        with pytest.raises(failures.LogTruncated, match=r"pairs\.dump"):
            contacts(text[:end], frames=3)


@pytest.mark.parametrize(
    ("line", "instead", "failure"),
    [
        ("2 0.25 \n", "2 \n", failures.LogTruncated),
        ("2 0.25 \n", "\n", failures.LogTruncated),
        ("2 0.25 \n", "", failures.LogTruncated),
        ("2 0.25 \n", "2 0.25 \n" * 2, failures.LogTruncated),
        ("3 0.125 \n", "3 0.125 1 \n", failures.LogTruncated),
        ("3 0.125 \n", "3 nan \n", failures.NotFinite),
        ("3 0.125 \n", "3 0.1#5 \n", failures.NotFinite),
        ("3 0.125 \n", "# 0.125 \n", failures.NotFinite),
    ],
)
def test_garbled_contacts_are_named(line, instead, failure):
    with pytest.raises(failure, match=r"pairs\.dump"):
        frames_of(LOCAL.replace(line, instead))


CONTACTS = (
    "ITEM: TIMESTEP\n0\nITEM: NUMBER OF ENTRIES\n2\nITEM: BOX BOUNDS ff ff ff\n0 1\n0 1\n0 1\n"
    "ITEM: ENTRIES c_pairs[1] c_pairs[2] c_pairs[4] c_pairs[5] c_pairs[6] \n"
    "1 2 0.1 0.2 0.3 \n3 1 0.4 0.5 0.6 \n"
)


def contacts(text, *, frames=1, spheres=3, partners=3, with_wall=False):
    return output.read_contacts(
        text,
        "pairs.dump",
        frames=frames,
        ids=(spheres, partners),
        with_wall=with_wall,
        rolling=False,
    )


def test_contacts_are_those_of_spheres_counted_from_0():
    found = contacts(CONTACTS)
    assert (found.first.tolist(), found.second.tolist()) == ([0, 2], [1, 0])
    found = contacts(CONTACTS, spheres=2, partners=4, with_wall=True)  # of triangles 1 and 3
    assert (found.first.tolist(), found.second.tolist()) == ([1, 0], [1, 3])


@pytest.mark.parametrize("garbled", ["9 1 0.4", "0 1 0.4", "3 -1 0.4", "3 1.5 0.4", "3e9 1 0.4"])
def test_a_contact_with_a_sphere_that_is_not_there_is_named(garbled):
    with pytest.raises(failures.ParticlesLost, match=r"pairs\.dump: contact 2 of"):
        contacts(CONTACTS.replace("3 1 0.4", garbled))


def test_frames_of_contacts_out_of_order_are_named():
    with pytest.raises(failures.LogTruncated, match="step '0' out of order"):
        frames_of(LOCAL.replace("TIMESTEP\n4", "TIMESTEP\n0"))
    with pytest.raises(failures.LogTruncated, match="step 'x' out of order"):
        frames_of(LOCAL.replace("TIMESTEP\n4", "TIMESTEP\nx"))
