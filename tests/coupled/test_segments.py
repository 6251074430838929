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


@pytest.mark.parametrize("settled", [0, 150])
def test_a_short_record_has_two_segments_side_by_side(settled):
    # of the differences of its rows, one fewer
    assert record(40.0, 1e-3, settled + 401, settled).segment == 200
    assert record(40.0, 1e-3, settled + 402, settled).segment == 200
    assert record(40.0, 1e-3, settled + 403, settled).segment == 201
