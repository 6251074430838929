"""What a surface is taught and asked: errors, bounds and the columns of its table."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping import surface_files
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import (
    AXES,
    ERROR,
    MASS,
    MASS_ERROR,
    PARTICLE_MASS,
    VALUE,
    onset,
)
from pidpanel.damping.tables import to_frame

MASS_PER_FILL = 13.0


def cases(fills=(0.2, 0.5, 0.8), levels=(3.0, 30.0, 300.0), frequencies=(30.0, 250.0, 2000.0)):
    r, f, a = (g.ravel() for g in np.meshgrid(fills, frequencies, levels, indexing="ij"))
    value = 4 * r * f * a**-0.8
    return pd.DataFrame(
        {"fill_fraction": r, "frequency_hz": f, "acceleration_g": a, VALUE: value,
         ERROR: 0.02 * value, MASS: 5 * r, MASS_ERROR: 0.1 + 0.3 * r,
         PARTICLE_MASS: MASS_PER_FILL * r}
    )  # fmt: skip


@pytest.fixture(scope="module")
def surface():
    return DampingSurface.from_frame(cases())


def test_a_surface_is_taught_logarithms_and_masses_with_the_errors_that_follow(surface):
    # C_e = r f h e^g, so δg = δC/C; m_a = r [h g + (1 − h) m₁], so δg = δm/(r h)
    # red: mass_error / (fill * h) → / (fill / h) in `taught`
    frame = cases()
    r, f, a = (frame[axis].to_numpy() for axis in AXES)
    h = onset(a, 1.0)
    np.testing.assert_allclose(r * f * h * np.exp(surface.damping.riding.values), frame[VALUE])
    np.testing.assert_allclose(surface.damping.riding.error, 0.02)
    taught = surface.mass.riding.values
    np.testing.assert_allclose(r * (h * taught + (1 - h) * MASS_PER_FILL), frame[MASS])
    np.testing.assert_allclose(r * h * surface.mass.riding.error, frame[MASS_ERROR])


def test_the_bound_is_that_of_an_inelastic_bed_where_the_mass_is_known(surface):
    # C_e ≤ 4 m₁ r ω/π = 8 m₁ r f; red: 8 * mass_per_fill → / in `DampingSurface`
    assert surface.bound == pytest.approx(8 * MASS_PER_FILL)
    unknown = DampingSurface.from_frame(cases().drop(columns=PARTICLE_MASS))
    assert unknown.bound == np.inf


def test_a_sweep_of_one_acceleration_has_a_hull_in_the_other_two():
    # without the corner of high fill and high frequency; the line from (0.5, 2000) to (0.8, 250)
    # red: of.shape[1] < 2 → <= 2 in `_facets`
    frame = cases(levels=(30.0,))
    lacking = (frame["fill_fraction"] == 0.8) & (frame["frequency_hz"] == 2000)
    found = DampingSurface.from_frame(frame[~lacking])
    middle = np.sqrt(250 * 2000)
    inside = [found.inside(np.array([[0.65 + d, middle, 30.0]]))[0] for d in (-0.01, 0.01)]
    assert inside == [True, False]


def test_the_table_of_a_surface_has_its_columns_and_the_mass_of_its_particles(surface):
    # red: surface.mass_per_fill * frame["fill_fraction"] → / in `to_frame`; drop=True → False
    assert list(surface.cases.columns) == [*AXES, VALUE, ERROR, MASS, MASS_ERROR]
    frame = to_frame(surface, 2, 3, 2)
    np.testing.assert_allclose(frame[PARTICLE_MASS], MASS_PER_FILL * frame["fill_fraction"])
    values = surface.at(*(frame[axis] for axis in AXES))
    np.testing.assert_allclose(frame[VALUE], values.equivalent_damping)
    np.testing.assert_allclose(frame[MASS], values.apparent_mass)


def test_a_table_has_five_fills_nine_frequencies_and_seven_accelerations(surface):
    # red: fills = 5 → 6; frequencies = 9 → 10; accelerations = 7 → 8
    frame = to_frame(surface)
    assert [frame[axis].round(9).nunique() for axis in AXES] == [5, 9, 7]


def test_a_surface_of_one_acceleration_has_its_covariance_whatever_is_asked():
    # red: self.low[2] → self.low[3] in `_held`
    one = DampingSurface.from_frame(cases(levels=(30.0,)))
    assert not one.depends_on_acceleration
    frequency = np.array([50.0, 400.0])
    asked = [one.covariance(frequency, 0.5, gamma) for gamma in (3.0, 30.0, 300.0)]
    np.testing.assert_array_equal(asked[0], asked[1])
    np.testing.assert_array_equal(asked[2], asked[1])
    assert (np.diag(asked[1]) > 0).all()


def test_the_grid_of_the_file_spans_the_cases(surface):
    # red: a start or an end of an axis of `to_dataset` left out
    grid = surface_files.to_dataset(surface)
    for axis, low, high in zip(AXES, (0.2, 30.0, 3.0), (0.8, 2000.0, 300.0), strict=True):
        values = grid[axis].to_numpy()
        assert values[0] == pytest.approx(low) and values[-1] <= high * (1 + 1e-9)
        assert (np.diff(values) > 0).all() and len(values) > 15
