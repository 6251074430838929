"""The response beside an integration in time."""

import numpy as np
import scipy

from pidpanel.solve.dampers import attach_dampers
from pidpanel.solve.modal import bare_panels
from pidpanel.solve.model import ModalBasis, Patches


def test_a_panel_with_a_patch_moves_alike_in_the_time_domain(panel):
    # six modes coupled by a heavy, strong patch under two independent forces, white noise through
    # a Butterworth filter at 150 Hz, held over steps of 1/3000 s; each state of the diagonal form
    # is propagated exactly. The mean square of the first mode, ζ = 5.5 % with the damper, spreads
    # by 1/√(2πζfT) = 0.7 % over 1000 s, the rms by half of that, and holding the force costs at
    # most (π·150/3000)²/6 = 0.4 % at the top of the band: 1 %
    step, count, n = 1 / 3000, 3_000_000, 6
    order = np.argsort(panel.basis.natural_frequency)[:n]
    shape = panel.points[:, order]
    basis = ModalBasis(
        panel.basis.natural_frequency[order], panel.basis.modal_mass[order], np.full(n, 0.03)
    )
    overlap = panel.patches.overlap[:1, order][:, :, order]
    damping, mass = 800.0, 4.0
    push = np.random.default_rng(7).standard_normal((n, 2))

    M = np.diag(basis.modal_mass) + mass * overlap[0]
    C = np.diag(basis.damping) + damping * overlap[0]
    K = np.diag(basis.modal_mass * basis.angular_frequency**2)
    inverse = np.linalg.inv(M)
    A = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ K, -inverse @ C]])
    B = np.concatenate([np.zeros((n, 2)), inverse @ push])
    rate, V = np.linalg.eig(A)
    propagator = np.exp(rate * step)
    input_of = ((propagator - 1) / rate)[:, None] * np.linalg.solve(V, B.astype(complex))
    tone = scipy.signal.butter(4, 150.0, fs=1 / step)
    random = np.random.default_rng(8)
    force = np.stack([scipy.signal.lfilter(*tone, random.standard_normal(count)) for _ in range(2)])
    output = np.concatenate([-inverse @ K, -inverse @ C], axis=1) @ V  # modal accelerations
    acceleration = shape @ (inverse @ push @ force)
    for state in np.flatnonzero(rate.imag > 0):  # the others are the conjugates
        driven = scipy.signal.lfilter([0, 1], [1, -propagator[state]], input_of[state] @ force)
        acceleration += 2 * ((shape @ output[:, state])[:, None] * driven).real
    in_time = np.std(acceleration[:, 20_000:], axis=1)

    frequency = np.linspace(0.5, 1000.0, 4000)
    _, gain = scipy.signal.freqz(*tone, frequency, fs=1 / step)
    psd = 2 * step * np.abs(gain) ** 2
    patches = Patches(overlap, np.array([0.04]))
    (bare,) = bare_panels(
        frequency, basis, [patches], shape, psd, push @ push.T, overlap_cutoff=1e-14
    )
    flat = np.ones((1, frequency.size))
    response = attach_dampers(bare, damping * flat, mass * flat)
    np.testing.assert_allclose(in_time, response.acceleration_rms, rtol=0.01)
