"""Motions of points with flat PSDs."""

import numpy as np

from pidpanel.severity.tables import Bursts, PointMotion

WHERE = {"scenario": "A"}
FREQUENCY = np.linspace(20.0, 500.0, 961)
ERROR = 0.2  # of rms values, relative


def motion(psd, *, points=("P",), error=ERROR):
    count = len(points)
    values = np.full((FREQUENCY.size, count), psd)
    errors = np.full(count, error)
    return PointMotion(WHERE, list(points), FREQUENCY, values, errors, Bursts.none(count))
