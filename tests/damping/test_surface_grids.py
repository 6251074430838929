"""The values that a surface computes once: on grids that are even, reach from end to end, no finer
than needed, and that say what the surface itself says."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping.models import NODE_STEP
from pidpanel.damping.surface import ACCELERATION_STEP, DampingSurface
from pidpanel.damping.surface_cases import (
    AXES,
    ERROR,
    MASS,
    MASS_ERROR,
    PARTICLE_MASS,
    VALUE,
    SurfaceBed,
    counted,
    training_data,
)

FILLS, FREQUENCIES, ACCELERATIONS = (0.2, 0.45, 0.8), (35.0, 120.0, 900.0), (4.0, 25.0, 160.0)


def made_of(fills=FILLS, frequencies=FREQUENCIES, accelerations=ACCELERATIONS):
    """Surface of cases of a smooth law, in a range that is another on every axis."""
    grid = np.meshgrid(fills, frequencies, accelerations, indexing="ij")
    r, f, g = (axis.ravel() for axis in grid)
    rows = {
        **dict(zip(AXES, (r, f, g), strict=True)), VALUE: 3 * r * f * g**-0.7 * (1 + 20 * g / f),
        ERROR: 0.1 * r * f * g**-0.7, MASS: 9 * r * g**-0.15, MASS_ERROR: 0.05,
        PARTICLE_MASS: 12 * r,
    }  # fmt: skip
    return DampingSurface.from_frame(pd.DataFrame(rows))


@pytest.fixture(scope="module")
def surface():
    return made_of()


def test_one_frequency_and_one_acceleration_still_have_two_nodes():
    surface = made_of(frequencies=(120.0,), accelerations=(25.0,))
    np.testing.assert_allclose(np.log(surface.nodes), np.log(120.0) + np.array([0, NODE_STEP]))
    values = surface.log_acceleration
    np.testing.assert_allclose(values, np.log(25.0) + np.array([0, ACCELERATION_STEP]))
    assert not surface.depends_on_acceleration


@pytest.mark.parametrize("fill", [0.1, 0.2, 0.37, 0.8, 0.95])
@pytest.mark.parametrize("gamma", [2.0, 4.0, 4.1, 21.0, 160.0, 400.0])
def test_what_is_computed_once_is_what_the_surface_says_within_and_beyond_the_cases(
    surface, fill, gamma
):
    frequency = np.array([10.0, 35.0, 36.3, 222.0, 899.0, 900.0, 3000.0])
    read = surface(frequency, fill, gamma)
    said = surface.evaluate(fill, frequency, gamma)
    # linear between values: 3e-3 of ln C_e, see FREQUENCY_STEP
    np.testing.assert_allclose(
        np.log(read.equivalent_damping), np.log(said.equivalent_damping), atol=3e-3
    )
    np.testing.assert_allclose(read.apparent_mass, said.apparent_mass, rtol=3e-3)
    np.testing.assert_allclose(
        read.equivalent_damping_error, said.equivalent_damping_error, rtol=2e-2
    )
    np.testing.assert_array_equal(read.inside, said.inside)


def test_at_the_values_computed_once_nothing_is_interpolated(surface):
    k, m = 7, 11
    frequency = np.exp(surface.log_frequency[[0, m, -1]])
    for log_gamma in surface.log_acceleration[[0, k, -1]]:
        read = surface(frequency, 0.45, np.exp(log_gamma))
        said = surface.evaluate(0.45, frequency, np.exp(log_gamma))
        np.testing.assert_allclose(read.equivalent_damping, said.equivalent_damping, rtol=1e-9)


def test_one_case_without_mass_leaves_the_mass_of_the_others():
    frame = made_of().cases
    frame.loc[0, MASS] = 0.0
    assert DampingSurface.from_frame(frame).mass is not None
    assert DampingSurface.from_frame(frame.assign(**{MASS: 0.0})).mass is None


def test_without_the_mass_of_the_particles_the_apparent_mass_is_taught_as_it_is():
    frame = made_of().cases  # which has no column of the particles' mass
    surface = DampingSurface.from_frame(frame)
    h = 1 - 1 / frame[AXES[2]] ** 2
    np.testing.assert_allclose(surface.mass.riding.values, frame[MASS] / (frame[AXES[0]] * h))


def test_cases_made_of_given_processes_teach_them_back():
    # C_e = r f h e^g and m_a = r [h g_m + (1 − h) 12], above an onset of 1.5 g
    g, g_m = np.array([0.3, -1.2, 2.0]), np.array([7.0, 3.0, 0.5])
    r, f, gamma = np.array([[0.2, 0.5, 0.8], [40.0, 90.0, 400.0], [3.0, 15.0, 1.875]])
    h = np.array([0.75, 0.99, 0.36])
    columns = {
        AXES[0]: r, AXES[1]: f, AXES[2]: gamma,
        VALUE: r * f * h * np.exp(g), MASS: r * (h * g_m + (1 - h) * 12),
        PARTICLE_MASS: 12 * r,
    }  # fmt: skip
    rows, mass_per_fill = counted(pd.DataFrame(columns)[::-1], 1.5)
    assert mass_per_fill == pytest.approx(12.0)
    # in the order of the table, with errors of 0 where none are stated
    assert list(rows.columns) == [*AXES, VALUE, ERROR, MASS, MASS_ERROR]
    assert list(rows[AXES[0]]) == [0.8, 0.5, 0.2]
    assert not rows[[ERROR, MASS_ERROR]].to_numpy().any()
    rows = rows.assign(**{ERROR: 0.1 * rows[VALUE], MASS_ERROR: 0.05})
    data = training_data(rows, SurfaceBed(1.5, 12.0, np.nan))
    np.testing.assert_allclose(data.log_damping, g[::-1])
    np.testing.assert_allclose(data.log_error, 0.1)
    np.testing.assert_allclose(data.mass, g_m[::-1], atol=1e-12)
    np.testing.assert_allclose(data.mass_error, 0.05 / (r * h)[::-1])
