"""Whatever is done to a cycle file, the reader gives the same numbers or a named failure."""

from pathlib import Path

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st

from pidpanel.coupon.liggghts import failures, output

WHOLE = (Path(__file__).parent / "golden" / "shake" / "cycles_1.txt").read_text()
LINES = WHOLE.splitlines(keepends=True)
ROWS = np.loadtxt(WHOLE.splitlines())
FIELD = {column: i for i, column in enumerate(output.CYCLE_COLUMNS)}


def same_or_named(text):
    """None if the reader refuses by name; else the rows must be those that were written."""
    try:
        rows = output.read_cycles(text, "cycles.txt", steps_per_cycle=1000, cycles=len(ROWS))
    except failures.SolverFailure:
        return
    np.testing.assert_array_equal(rows, ROWS)


@settings(max_examples=100, deadline=None)
@given(st.integers(0, len(WHOLE)), st.integers(0, len(WHOLE)))
def test_a_piece_cut_out_of_the_file(a, b):
    # a cut within one number leaves a shorter number: no reader can know, so cuts of whole
    # digits inside a field are left to the next test, which says what is possible
    start, stop = sorted((a, b))
    piece = WHOLE[start:stop]
    if "\n" in piece or " " in piece or not piece:
        text = WHOLE[:start] + WHOLE[stop:]
        if text.count("\n") != WHOLE.count("\n") or text.count(" ") != WHOLE.count(" "):
            same_or_named(text)


@settings(max_examples=100, deadline=None)
@given(st.lists(st.sampled_from(range(len(LINES))), min_size=0, max_size=len(LINES) + 3))
def test_lines_dropped_repeated_and_shuffled(order):
    same_or_named("".join(LINES[i] for i in order))


@settings(max_examples=100, deadline=None)
@given(
    st.integers(2, len(LINES) - 1),
    st.integers(0, len(output.CYCLE_COLUMNS) - 1),
    st.text(st.characters(exclude_categories=["Cs", "Nd"]), min_size=1, max_size=8),
)
def test_a_field_garbled_without_digits(line, field, garble):
    fields = LINES[line].rstrip("\n").split(" ")
    fields[field] = garble
    same_or_named("".join([*LINES[:line], " ".join(fields) + "\n", *LINES[line + 1 :]]))


@settings(max_examples=100, deadline=None)
@given(st.integers(0, len(WHOLE)), st.binary(min_size=1, max_size=12))
def test_bytes_thrown_into_the_file(position, junk):
    text = junk.decode("latin-1")
    if not any(c.isdigit() or c in "+-.eE" for c in text):
        same_or_named(WHOLE[:position] + text + WHOLE[position:])
