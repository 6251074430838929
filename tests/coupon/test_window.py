"""The window of the energy balance, as far as it reads files."""

from types import SimpleNamespace

import numpy as np
import pytest

from pidpanel.coupon import window
from pidpanel.coupon.liggghts.failures import LogTruncated
from pidpanel.coupon.records import RunState
from tests.coupons import small_cases


def test_files_that_end_at_the_same_frame_are_told(monkeypatch, tmp_path):
    run = small_cases()[0].point
    motion = tmp_path / "spheres.bin"
    motion.touch()

    def list_contacts(steps, stride, *, rolling):
        read = SimpleNamespace(position=np.zeros((steps // stride, 8, 3)))
        monkeypatch.setattr(window.output, "read_motion", lambda *_, **__: read)
        return 0, SimpleNamespace(motion=motion)

    solver = SimpleNamespace(list_contacts=list_contacts)
    with pytest.raises(LogTruncated, match=r"spheres.bin: (\d+) of (?!\1 )\d+ frames"):
        window._window(solver, run, RunState("", 8, 1e-4, (), (), 0, {}), tmp_path, 6)
