"""A panel whose shapes are products of sines, with everything the response asks of it."""

from dataclasses import dataclass

import numpy as np
import pytest

from pidpanel.solve.model import ModalBasis, Patches

SIDES = (1.5, 1.0)
SPEED = 343.0


@dataclass(frozen=True)
class SinePanel:
    """The paper's thin panel, m″ = 4 kg/m², ζ = 1 %, with PID-1 and PID-2."""

    modes: list[tuple[int, int]]

    def shape(self, position):
        x, y = np.asarray(position, dtype=float).T
        return np.stack(
            [
                np.sin(m * np.pi * x / SIDES[0]) * np.sin(n * np.pi * y / SIDES[1])
                for m, n in self.modes
            ],
            axis=1,
        )

    @property
    def basis(self) -> ModalBasis:
        frequency = [44.9332 * (m**2 / SIDES[0] ** 2 + n**2 / SIDES[1] ** 2) for m, n in self.modes]
        mass = np.full(len(self.modes), 4.0 * SIDES[0] * SIDES[1] / 4)
        return ModalBasis(frequency, mass, 0.01)

    @property
    def points(self):
        """Points 326, 189 and 318 of the paper."""
        return self.shape([(0.75, 0.50), (0.10, 0.30), (0.35, 0.50)])

    def overlap(self, center, side=0.2, order=24):
        node, weight = np.polynomial.legendre.leggauss(order)
        x, y = np.meshgrid(center[0] + side / 2 * node, center[1] + side / 2 * node, indexing="ij")
        shape = self.shape(np.stack([x.ravel(), y.ravel()], axis=1))
        return shape.T @ (np.outer(weight, weight).ravel()[:, None] * side**2 / 4 * shape)

    @property
    def patches(self) -> Patches:
        return Patches(
            np.stack([self.overlap((0.75, 0.50)), self.overlap((0.10, 0.30))]),
            np.array([0.04, 0.04]),
        )

    def modal_force(self, frequency):
        """G of a diffuse field by a plain double integral on few points, for few lines."""
        node, weight = np.polynomial.legendre.leggauss(22)
        x, y = np.meshgrid(SIDES[0] / 2 * (1 + node), SIDES[1] / 2 * (1 + node), indexing="ij")
        position = np.stack([x.ravel(), y.ravel()], axis=1)
        load = (np.outer(weight, weight).ravel() * SIDES[0] * SIDES[1] / 4)[:, None] * self.shape(
            position
        )
        apart = np.linalg.norm(position[:, None] - position[None], axis=2)
        return np.stack(
            [load.T @ np.sinc(2 * f / SPEED * apart) @ load for f in np.atleast_1d(frequency)]
        )


@pytest.fixture(scope="session")
def panel() -> SinePanel:
    return SinePanel([(m, n) for m in range(1, 8) for n in range(1, 6)])


@pytest.fixture(scope="session")
def lines(panel):
    """Lines over the range, with G and a damper of the size that particles make."""
    frequency = np.geomspace(30.0, 1500.0, 23)
    return Lines(
        frequency,
        panel.modal_force(frequency),
        np.stack([2000 * (frequency / 100) ** 0.5, 500 * (frequency / 100) ** 0.8]),
        np.stack([6.4 * (frequency / 50) ** -0.3, np.full(frequency.size, 3.0)]),
        1e2 * (frequency / 100) ** -1.0,
    )


@dataclass(frozen=True)
class Lines:
    frequency: np.ndarray
    modal_force: np.ndarray
    equivalent_damping: np.ndarray
    apparent_mass: np.ndarray
    spectrum: np.ndarray
