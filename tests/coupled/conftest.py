"""A plate of few shapes in closed form, and particles that have an impedance in closed form."""

from types import SimpleNamespace

import numpy as np
import pytest

from pidpanel.coupled.integration import PanelShapes


class Oscillators:
    """A mass on a spring and a dashpot in every cell: Z = iωm (k + iωc)/(k − ω²m + iωc).

    Moved as LIGGGHTS moves its spheres: force from the place at the end of a step and the speed
    of its middle.
    """

    def __init__(self, mass, stiffness, damping, time_step):
        self.mass, self.stiffness, self.damping = mass, stiffness, damping
        self.time_step = time_step
        self.place = np.zeros_like(mass)
        self.speed = np.zeros_like(mass)
        self.force = np.zeros_like(mass)

    def wall_force(self):
        return self.force

    def step(self, kick):
        self.speed = self.speed + kick + self.time_step * self.force / self.mass
        self.place = self.place + self.time_step * self.speed
        self.force = -self.stiffness * self.place - self.damping * self.speed

    def impedance(self, frequency):
        """(nf, k) force of the panel over its velocity [N s/m]."""
        omega = 2 * np.pi * frequency[:, None]
        spring = self.stiffness + 1j * omega * self.damping
        return 1j * omega * self.mass * spring / (spring - omega**2 * self.mass)


def _plate(nx=5, ny=3):
    """Simply supported, 1.0 m × 0.7 m, 4 kg/m², f = 20 (m² + (n/0.7)²) Hz, ζ = 2 %."""
    order = [(m, n) for m in range(1, nx + 1) for n in range(1, ny + 1)]
    frequency = np.array([20.0 * (m**2 + (n / 0.7) ** 2) for m, n in order])

    def shape(x, y):
        rows = [np.sin(m * np.pi * x) * np.sin(n * np.pi * y / 0.7) for m, n in order]
        return np.array(rows).T

    stations = np.array([[x, y] for x in (0.35, 0.45, 0.55, 0.65) for y in (0.3, 0.4)])
    points = np.array([[0.5, 0.35], [0.2, 0.1]])
    shapes = PanelShapes(
        angular_frequency=2 * np.pi * frequency,
        damping_ratio=np.full(len(order), 0.02),
        modal_mass=np.full(len(order), 4.0 * 0.7 / 4),
        at_stations=shape(*stations.T),
        at_points=shape(*points.T),
    )

    def stiffness(f):
        omega = 2 * np.pi * f[:, None]
        own = shapes.angular_frequency
        return shapes.modal_mass * (own**2 - omega**2 + 2j * shapes.damping_ratio * own * omega)

    return SimpleNamespace(
        shapes=shapes, stiffness=stiffness, area=np.full(8, 0.01), shape=shape, count=len(order)
    )


@pytest.fixture(scope="session")
def plate():
    return _plate()


@pytest.fixture(scope="session")
def oscillators():
    return Oscillators
