"""C_e and m_a from force over acceleration in universal files."""

import numpy as np
import pytest

from pidpanel.columns import ColumnsError
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.identify.force_files import read_force

F = np.arange(20.0, 1000.0, 2.0)
AREA, FIXTURE = 2e-3, 0.4
DAMPING, MASS = 800.0, 5.0


@pytest.fixture
def written(force_file):
    def write(values, unit="m/s^2", kinds=(13, 12), function=4, force="N", lines=F, even=1):
        above, below = (force, unit) if kinds[0] == 13 else (unit, force)
        return force_file(
            values, lines, func_type=function, abscissa_spacing=even,
            ordinate_spec_data_type=kinds[0], ordinate_axis_units_lab=above,
            orddenom_spec_data_type=kinds[1], orddenom_axis_units_lab=below,
        )  # fmt: skip

    return write


def apparent_mass():
    """F/a [kg] of constant C_e and m_a: Z/(iω) = m_a − i C_e/ω."""
    return FIXTURE + AREA * (MASS - 1j * DAMPING / (2 * np.pi * F))


@pytest.mark.parametrize(
    ("values", "options"),
    [
        (apparent_mass(), {}),
        (apparent_mass() * STANDARD_GRAVITY, {"unit": "g"}),
        (apparent_mass() * STANDARD_GRAVITY, {"unit": "[g]"}),
        (apparent_mass() * STANDARD_GRAVITY, {"unit": "g_n"}),
        (apparent_mass() * STANDARD_GRAVITY, {"unit": "g (rms)", "force": "N rms"}),
        (apparent_mass() * 1e-3, {"unit": "mm/s^2"}),
        (apparent_mass() * 1e-3 * 0.0254, {"unit": "in/s²", "force": "kN"}),
        (apparent_mass() / 0.45359237, {"unit": "g", "force": "lbf"}),
        (1 / apparent_mass(), {"kinds": (12, 13)}),
        (1e3 / apparent_mass(), {"kinds": (12, 13), "unit": "mm/s2"}),
    ],
)
def test_constants_come_back(written, values, options):
    bands = read_force(written(values, **options), None, AREA, FIXTURE)
    np.testing.assert_allclose(bands.damping, DAMPING, rtol=1e-5)
    np.testing.assert_allclose(bands.mass, MASS, rtol=1e-5)
    assert (bands.damping_error < 1e-2).all()
    # third octaves with four lines and more
    assert 30 < bands.frequency[0] < 45 and 900 < bands.frequency[-1] < 1000


def test_scatter_of_the_lines_is_the_error_of_a_band(written):
    rng = np.random.default_rng(4)
    noisy = apparent_mass() * (1 + 0.1 * rng.standard_normal(F.size))
    bands = read_force(written(noisy), None, AREA, FIXTURE)
    score = (bands.damping - DAMPING) / bands.damping_error
    assert 0.5 < np.sqrt(np.mean(score**2)) < 1.7


@pytest.mark.parametrize(("first", "size"), [(-1, 0.5), (12, 300.0)])
def test_a_band_has_the_mean_of_its_lines(written, first, size):
    bands = np.arange(first, first + 4)  # 10^(n/10) Hz, from 0.8 and 16 Hz on
    shares = np.array([-0.04, -0.02, 0.01, 0.045])
    f = 10 ** ((bands[:, None] + 10 * shares) / 10)
    damping = size * (1 + 0.1 * np.arange(16.0).reshape(4, 4) ** 0.5)
    mass = FIXTURE + AREA * (MASS - 1j * damping / (2 * np.pi * f))
    path = written(mass.ravel(), lines=f.ravel(), even=0)
    means = read_force(path, None, AREA, FIXTURE)
    np.testing.assert_allclose(means.frequency, f.prod(axis=1) ** 0.25, rtol=1e-5)
    np.testing.assert_allclose(means.damping, damping.sum(axis=1) / 4, rtol=1e-5)
    away = damping - damping.mean(axis=1, keepdims=True)
    # √(Σ d² / (n − 1) / n), of differences between numbers of six digits
    expected = np.sqrt((away**2).sum(axis=1) / 12)
    np.testing.assert_allclose(means.damping_error, expected, rtol=1e-3)


@pytest.mark.parametrize(
    ("values", "options", "message"),
    [
        (apparent_mass(), {"function": 9}, "must be a frequency response"),
        (apparent_mass(), {"kinds": (12, 12)}, "of force over acceleration or the inverse"),
        (
            apparent_mass(),
            {"force": "V"},
            "unit 'V' over 'm/s\\^2': 'V' is not a known unit; force",
        ),
        (apparent_mass(), {"unit": "mm"}, "unit 'N' over 'mm': force over acceleration must be in"),
        (apparent_mass(), {"unit": ""}, "must be in units such as N and m/s\\^2, lbf and g"),
        (1 / apparent_mass(), {"kinds": (12, 13), "force": "NONE"}, "unit 'm/s\\^2': acceleration"),
        (apparent_mass().conj(), {}, "C_e is negative in all third octaves"),
    ],
)
def test_other_functions_are_refused(written, values, options, message):
    with pytest.raises(ColumnsError, match=message):
        read_force(written(values, **options), None, AREA, FIXTURE)
