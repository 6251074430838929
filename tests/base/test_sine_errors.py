"""Standard errors of sine sweeps against derivatives of the linear panel."""

from dataclasses import replace

import numpy as np
import pytest
from moving import solved, transfer_of

from pidpanel.base.sine import damping_errors, sweep, sweep_errors
from pidpanel.damping.models import DampingValues, FilledDamper
from pidpanel.solve.layout import AttachedDamper

FREQUENCY = np.linspace(55.0, 75.0, 41)
AMPLITUDE, MASS = 1.0, 2.0
ERROR, MASS_ERROR, CORRELATION = 2e-3, 4e-3, 0.6
STEP = 1e-4


class PowerLaw:
    """C_e = c Γⁿ, with errors of its logarithm and of m_a that rise with frequency."""

    depends_on_acceleration = True
    nodes = np.array([50.0, 65.0, 80.0])

    def __init__(self, power, correlation=CORRELATION):
        self.power, self.correlation = power, correlation

    def __call__(self, frequency, fill_fraction, gamma):
        damping = 400 * (gamma / 10) ** self.power + 0 * frequency
        return DampingValues(damping, 0 * frequency, MASS + 0 * frequency, frequency > 0)

    def covariance(self, frequency, fill_fraction, gamma):
        error = np.array([ERROR, MASS_ERROR]) * frequency[0] / 65
        return np.outer(error, error) * [[1, self.correlation], [self.correlation, 1]]


def attached(damper):
    return AttachedDamper(0, damper.damping, damper.depends_on_acceleration)


def errors_of(panel, model):
    """Γ and the errors of the amplitudes of the points."""
    transfer, damper = transfer_of(panel, FREQUENCY), FilledDamper("law", model, 1.0)

    def amplitudes(loads):
        run = sweep(transfer, loads, AMPLITUDE)
        return {"points": np.abs(run.motion.reshape(FREQUENCY.size, -1)[:, [0, 2]])}

    gamma = sweep(transfer, [attached(damper)], AMPLITUDE).acceleration_g[0]
    errors = [damping_errors(damper, FREQUENCY, gamma)]
    return gamma, sweep_errors([attached(damper)], ["law"], errors, amplitudes)["points"]


def slopes_of(panel, damping):
    """d ln of Γ (nf, 1) and of the points (nf, 2), by ln C_e and by m_a on a linear panel."""

    def logs(factor, mass):
        points, patch = [], []
        for line, value in enumerate(damping):
            f = FREQUENCY[line : line + 1]
            motion, _, transfer = solved(panel, f, factor * value, mass)
            s = 2j * np.pi * f * factor * value - (2 * np.pi * f) ** 2 * mass
            patch.append(transfer.patch_acceleration(slice(None), s[None])[0])
            points.append(np.abs(motion[0, :2, 0]))
        return np.log(patch), np.log(points)

    pairs = (
        (logs(1 + STEP, MASS), logs(1 - STEP, MASS)),
        (logs(1, MASS + STEP), logs(1, MASS - STEP)),
    )
    return [[(a - b) / (2 * STEP) for a, b in zip(*pair, strict=True)] for pair in pairs]


@pytest.mark.parametrize("power", [0.0, -0.5])
def test_errors_are_those_of_the_damping_at_the_motion_it_leads_to(panel, power):
    gamma, found = errors_of(panel, PowerLaw(power))
    (patch_c, points_c), (patch_m, points_m) = slopes_of(panel, 400 * (gamma / 10) ** power)
    follows = 1 / (1 - power * patch_c)
    by_damping = points_c * follows * ERROR
    by_mass = (points_m + points_c * power * follows * patch_m) * MASS_ERROR
    variance = by_damping**2 + by_mass**2 + 2 * CORRELATION * by_damping * by_mass
    expected = np.sqrt(variance) * FREQUENCY[:, None] / 65
    # C_e is linear in ln Γ in steps of 20 %: 2 % of its slope
    np.testing.assert_allclose(found, expected, rtol=0.02, atol=0.01 * expected.max())


def test_sources_err_independently_and_dampers_of_one_source_together(panel):
    transfer, model = transfer_of(panel, FREQUENCY), PowerLaw(0.0, 0.0)
    first = FilledDamper("law", model, 1.0)

    def error_with(second):
        # two dampers on one patch act like their sum
        def amplitudes(loads):
            both = replace(loads[0], damping=lambda f, g: _sum(loads, f, g))
            run = sweep(transfer, [both], AMPLITUDE)
            return {"point": np.abs(run.motion[:, 0])}

        gamma = np.full(FREQUENCY.size, 1.0)
        errors = [damping_errors(damper, FREQUENCY, gamma) for damper in (first, second)]
        pair = [attached(damper) for damper in (first, second)]
        names = [first.name, second.name]
        return sweep_errors(pair, names, errors, amplitudes)["point"]

    together, apart = error_with(first), error_with(replace(first, name="other"))
    np.testing.assert_allclose(together, np.sqrt(2) * apart, rtol=1e-3)


def _sum(loads, frequency, gamma):
    (c1, m1, inside), (c2, m2, _) = (load.damping(frequency, gamma) for load in loads)
    return c1 + c2, m1 + m2, inside


def test_damping_without_errors_gives_none(panel):
    model = PowerLaw(0.0)
    model.nodes = None
    damper = FilledDamper("law", model, 1.0)
    assert damping_errors(damper, FREQUENCY, FREQUENCY) is None
    assert sweep_errors([attached(damper)], ["law"], [None], lambda loads: {}) == {}
