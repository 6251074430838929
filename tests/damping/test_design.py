"""Which cases to run next: what is foretold of them comes true."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping import design
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import ERROR, VALUE
from pidpanel.damping.thinned import spread_out

POOL = np.stack(
    [
        g.ravel()
        for g in np.meshgrid([0.1, 0.5, 0.9], np.geomspace(30, 2000, 6), [4.0, 40.0, 400.0],
                             indexing="ij")
    ],
    axis=1,
)  # fmt: skip


def run(points):
    """Cases of a law with a bend, known to 5 %."""
    r, f, level = points.T
    value = 50 * r * f * level**-0.8 * (1 + 300 * level / f**2) ** 0.4
    return pd.DataFrame(
        {"fill_fraction": r, "frequency_hz": f, "acceleration_g": level, VALUE: value,
         ERROR: 0.05 * value, "apparent_mass_kg_m2": 0.3 * r * np.log(level),
         "apparent_mass_error_kg_m2": 0.01 * np.ones_like(r)}
    )  # fmt: skip


def spread(count):
    """Numbers of cases that are spread over the sweep."""
    at = np.column_stack([POOL[:, 0], np.log(POOL[:, 1:])])
    return spread_out(at / np.ptp(at, axis=0), count).tolist()


@pytest.fixture(scope="module")
def surface():
    return DampingSurface.from_frame(run(POOL[spread(14)]))


def wanted(surface, fill=0.5, level=40.0, at=300.0):
    """Something that reads C_e round one frequency, and m_a a little."""
    weight = np.exp(-(np.log(surface.nodes / at) ** 2) / 0.2)
    return design.Wanted(fill, level, np.concatenate([0.1 * weight, 0.01 * weight])[:, None])


def test_the_variance_taken_away_is_the_variance_that_is_gone(surface):
    one = wanted(surface)
    (before,) = design.variances(surface, [one])
    (gain,) = design.gains(surface, [one], POOL[[25]], 0.05)
    after = surface.with_case(POOL[[25]], 0.05)
    (left,) = design.variances(after, [one])
    # the width of the prior of the mean goes by the spread of the values, which one more alters
    assert before[0] - left[0] == pytest.approx(gain[0, 0], rel=0.03)
    assert gain[0, 0] > 0


def test_the_case_chosen_lies_where_it_is_read(surface):
    (first, *_) = design.next_cases(surface, [wanted(surface)], POOL, 0.05, 1e-4, 1)
    r, f, level = POOL[first]
    assert r == 0.5 and level == 40.0
    assert abs(np.log(f / 300)) < np.log(2.4)  # the run points stand a factor 2.3 apart


def test_a_batch_holds_no_case_twice_and_ends_where_the_target_is_met(surface):
    one = wanted(surface)
    batch = design.next_cases(surface, [one], POOL, 0.05, 1e-4, 6)
    assert len(set(batch)) == 6
    (variance,) = design.variances(surface, [one])
    assert design.next_cases(surface, [one], POOL, 0.05, 1.01 * variance[0] ** 0.5, 6) == []


def test_chosen_cases_narrow_it_more_than_cases_spread_evenly(surface):
    one = wanted(surface)
    start = spread(14)
    left = [i for i in range(len(POOL)) if i not in start]
    chosen = design.next_cases(surface, [one], POOL[left], 0.05, 1e-4, 4)
    even = [i for i in spread(18) if i not in start][:4]
    found = [
        design.variances(DampingSurface.from_frame(run(POOL[start + more])), [one])[0][0]
        for more in ([left[i] for i in chosen], even)
    ]
    assert found[0] < 0.5 * found[1]
