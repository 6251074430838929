"""Modes of one's own: a plate in arrays, where a damper on one of two patches is better."""

import numpy as np

from pidpanel.solve import layouts
from pidpanel.solve.excitation import ModalForce
from pidpanel.solve.layout import AttachedDamper, DamperLayout
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.panel import ModalPanel

# what a modal survey or another solver gives: here a simply supported plate of 0.8 m × 0.5 m
a, b, mass, stiffness = 0.8, 0.5, 4.0, 800.0  # [m], [m], [kg/m²], [N m]
orders = np.array([(m, n) for m in range(1, 5) for n in range(1, 4)])
wave = np.pi * orders / (a, b)  # [1/m]
frequency = np.sqrt(stiffness / mass) * (wave**2).sum(axis=1) / (2 * np.pi)  # [Hz]


def shapes(x, y):
    """Return the shapes at places: (n, n_modes)."""
    return np.sin(np.outer(x, wave[:, 0])) * np.sin(np.outer(y, wave[:, 1]))


def patch(x, y, edge=0.1, n=8):
    """Return D = ∫ φ φᵀ dA of a square patch [m²], by the mean of n × n places."""
    steps = (np.arange(n) + 0.5) / n * edge - edge / 2
    w = shapes(np.repeat(x + steps, n), np.tile(y + steps, n))
    return w.T @ w * edge**2 / n**2


basis = ModalBasis(frequency, np.full(len(orders), mass * a * b / 4), 0.01)
lines = frequency_grid(40, 350, 0.01, frequency)
panel = ModalPanel(
    basis,
    Patches([patch(0.4, 0.25), patch(0.2, 0.25)], [0.01, 0.01]),
    lines,
    shapes([0.3], [0.2]),  # a response point
    frequency_grid(40, 350, 0.01, lines_per_bandwidth=3),
)
# rain on the roof: 100 Pa²/Hz over 0.01 m², the same everywhere and incoherent
sound = ModalForce(lambda f: np.full(f.size, 100.0), 0.01 * np.eye(len(orders)) * a * b / 4)


def damping(f, gamma):
    """Return C_e [N s/m³], m_a [kg/m²] over frequency, and where both are known."""
    return np.full(f.size, 1000.0), np.full(f.size, 2.0), np.ones(f.size, bool)


placed = {"bare": [], "middle": [0], "quarter": [1]}
responses = layouts(
    panel,
    sound,
    [DamperLayout([AttachedDamper(k, damping) for k in patches]) for patches in placed.values()],
)
for name, found in zip(placed, responses, strict=True):
    print(f"{name}: {found.response.acceleration_rms[0]:.1f} m s-2 rms")
