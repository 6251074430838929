"""Modal force and added mass of sine shapes compared with independent integrals."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np

from pidpanel.sound.field import diffuse_modal_force, wavenumber
from pidpanel.sound.radiation import tabulate_added_mass
from pidpanel.verification import free_edges
from pidpanel.verification.free_edges import SIDES, SPEED, sine_panel
from pidpanel.verification.rows import Row, comparison

# Mode → frequency [Hz], G_ii [m⁴] by adaptive quadrature of the double integral in the distance,
# where the autocorrelations of the sines are closed forms; five figures.
JOINT_ACCEPTANCE = {
    (1, 1): (64.90, 0.34386),
    (3, 3): (584.1316, 0.028115),
    (9, 1): (1662.5284, 0.0032727),
}

# Mode → V at k = 0 [m³] by the same; five figures.
ADDED_VOLUME = {(1, 1): 0.18613, (3, 2): 0.04819}


def field_rows(_: Path) -> Iterator[Row]:
    """Return joint acceptances, a radiation efficiency and added masses of a 1.5 m × 1 m panel."""
    force = comparison("modal_force")
    panel = sine_panel(list(JOINT_ACCEPTANCE))
    for index, (mode, (frequency, reference)) in enumerate(JOINT_ACCEPTANCE.items()):
        k = float(wavenumber(frequency, SPEED))
        G = diffuse_modal_force(k, panel)
        quantity = f"modal force G of mode {mode} at {frequency:.2f} Hz"
        yield force.row(quantity, G[index, index], reference, frequency)
        if mode == (1, 1):
            # by reciprocity G_ii = (2π/k²) σ_i ∫φ_i² dA
            sigma = k**2 * G[0, 0] / (2 * np.pi * panel.product_integral[0, 0])
            quantity = f"radiation efficiency of mode (1, 1) at {frequency:.2f} Hz"
            yield comparison("efficiency").row(quantity, sigma, 0.2063, frequency)
    static = tabulate_added_mass(36.6, sine_panel(list(ADDED_VOLUME))).matrix([0.0])[0]
    mass = comparison("added_mass")
    for i, (mode, volume) in enumerate(ADDED_VOLUME.items()):
        yield mass.row(f"added mass over density of mode {mode}, k = 0", static[i, i].real, volume)
    panel = sine_panel([(1, 1)])
    piston = replace(panel, shape=np.ones_like(panel.shape))
    rigid = comparison("piston")
    volume = tabulate_added_mass(36.6, piston).matrix([0.0])[0, 0, 0].real
    yield rigid.row("added mass over density, k = 0", volume, piston_volume(*SIDES))


def piston_volume(a: float, b: float) -> float:
    """Return V = (1/2π) ∬∬ dA dA′/R [m³] over a rectangle of the sides a, b [m].

    By four integrations of 1/R, the energy of a plate of uniform charge.

    Examples
    --------
    Of a square of 1 m, (4/3)(1 − √2 + 3 ln(1 + √2))/2π:

    >>> round(piston_volume(1.0, 1.0), 5)
    0.4732
    """
    d = np.hypot(a, b)
    double = 2 * a**2 * b * np.log((b + d) / a) + 2 * a * b**2 * np.log((a + d) / b)
    return float((double + 2 / 3 * (a**3 + b**3 - d**3)) / (2 * np.pi))


CASES = {"field": field_rows, **free_edges.CASES}
