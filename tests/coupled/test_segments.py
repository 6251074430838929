"""A record is cut into segments that resolve its third octaves."""

import numpy as np
import pytest

from pidpanel.coupled.segments import SettledRecord


def record(lowest, interval, rows, settled=0, spacing=1.0):
    return SettledRecord(
        frequency=lowest + spacing * np.arange(5),
        amplitude=np.zeros((5, 1), complex),
        first=1,
        rows=rows,
        settled=settled,
        interval=interval,
        at_cells=np.zeros((rows, 1)),
        at_points=np.zeros((rows, 1)),
        impulse=np.zeros((rows, 1)),
    )


def test_lines_of_a_long_record_are_two_hertz_apart():
    # red: SEGMENT_S = 0.55; min → max
    assert record(40.0, 1 / 8000, 80001).segment == 4000


def test_a_segment_has_five_periods_of_the_lowest_tone():
    # 5/4 Hz, whose lines are nearer than a third octave at 4 Hz is wide
    # red: PERIODS * → PERIODS / ; frequency[0] → frequency[1]
    found = record(4.0, 1e-3, 80001)
    assert found.segment == 1250
    assert 1 / (1e-3 * found.segment) < 4.0 * (10**0.05 - 10**-0.05)


@pytest.mark.parametrize("settled", [0, 150])
def test_a_short_record_has_two_segments_side_by_side(settled):
    # of the differences of its rows, one fewer; red: `- settled` → `+`; `- 1` → `- 2`, `+ 1`
    assert record(40.0, 1e-3, settled + 401, settled).segment == 200
    assert record(40.0, 1e-3, settled + 402, settled).segment == 200
    assert record(40.0, 1e-3, settled + 403, settled).segment == 201
