"""What the approximation of the air in coupled runs does to g rms.

A coupled run integrates oscillators with the air at their own frequencies; the stated response has
the whole matrices of the air, with the C_e that the particles had in the motion of the run, carried
to that of the response with C_e ∝ v^−0.75. So the error is that of C_e. It is computed here without
particles: a damper on a patch has C_e ∝ v^−γ, and each of its fixed points is found in closed form,
in the oscillators and in the whole panel.

    python benchmarks/coupled_air.py

Panels of sines, simply supported; free, at two distances from a wall, and in a baffle; two patches;
C_e and m_a of light to heavy beds. Four CPU-minutes.
"""

from __future__ import annotations

import sys
from collections.abc import Callable

import numpy as np
from scipy.optimize import brentq

from pidpanel.coupled.excited_panel import loaded_shapes
from pidpanel.coupled.variants import EXPONENT
from pidpanel.geometry.plane_waves import PanelQuadrature, condensed
from pidpanel.solve.lines import frequency_grid
from pidpanel.solve.model import ModalBasis
from pidpanel.sound.field import tabulate_diffuse
from pidpanel.sound.free_edges import FreePanel, tabulate_diffuse_room
from pidpanel.sound.radiation import Air, tabulate_added_mass
from pidpanel.sound.rectangle import RectangleJumps

SPEED, DENSITY, RATIO = 343.0, 1.2, 0.01
# sides [m], bending stiffness [N m], mass per area [kg/m²], highest frequency [Hz]
PANELS = {
    "1.5 m × 1 m, to 400 Hz": ((1.5, 1.0), 3273.07, 4.0, 400.0),
    "1.5 m × 1 m, to 1000 Hz": ((1.5, 1.0), 3273.07, 4.0, 1000.0),
    "0.8 m × 0.6 m": ((0.8, 0.6), 800.0, 3.0, 800.0),
    "2.4 m × 1.2 m": ((2.4, 1.2), 12000.0, 3.5, 400.0),
    "1 m × 1 m, stiff": ((1.0, 1.0), 20000.0, 5.0, 800.0),
}
SURROUNDINGS = {"free": np.inf, "wall at 0.2 m": 0.2, "wall at 0.05 m": 0.05, "baffle": None}
PATCHES = ((0.5, 0.5), (0.25, 0.4))  # middles over the sides; a fifth of the shorter side wide
DAMPERS = ((200.0, 2.0), (1000.0, 6.0), (3000.0, 12.0))  # C_e [N s/m³], m_a [kg/m²]
EXPONENTS = (-1.0, 0.0, 0.4, 1.1)  # γ; stated errors hold 0.75 ± 0.35
LOWEST = 30.0


class Panel:
    """Sines of a panel in its surroundings."""

    def __init__(self, sides, bending, mass, top, wall) -> None:
        self.sides, orders = sides, [(m, n) for m in range(1, 25) for n in range(1, 25)]
        square = [sum((k / side) ** 2 for k, side in zip(o, sides, strict=True)) for o in orders]
        natural = np.pi / 2 * np.sqrt(bending / mass) * np.array(square)
        kept = np.argsort(natural)[: np.sum(natural < 1.3 * top)]
        self.orders = [orders[k] for k in kept]
        self.modal = ModalBasis(natural[kept], np.full(len(kept), mass * np.prod(sides) / 4), RATIO)
        self.extent, k_max = (LOWEST, top), 2 * np.pi * top / SPEED
        self.frequency = frequency_grid(LOWEST, top, RATIO, lines_per_bandwidth=3.0)
        face = self._face(2 * max(k_max, 1.2 * np.pi * np.sqrt(max(np.array(square)[kept]))))
        if wall is None:
            force, volume = tabulate_diffuse(k_max, face), tabulate_added_mass(k_max, face)
        else:
            jumps = RectangleJumps.of_box([0, 0], sides, max(k_max, face.wavenumber / 2))
            force, volume = tabulate_diffuse_room(FreePanel.of_jumps(jumps, k_max, wall), face)
        self.air = Air(DENSITY, SPEED, 1 if wall is None else 2, force, volume)
        self.force = force.matrix(2 * np.pi * self.frequency / SPEED)

    def _face(self, wavenumber: float) -> PanelQuadrature:
        node, weight = np.polynomial.legendre.leggauss(64)
        x, y = np.meshgrid(*((1 + node) / 2 * side for side in self.sides), indexing="ij")
        position = np.stack([x.ravel(), y.ravel()], axis=1)
        area = np.outer(weight, weight).ravel() * np.prod(self.sides) / 4
        overlap = np.eye(len(self.orders)) * np.prod(self.sides) / 4
        return condensed(
            PanelQuadrature(position, area, self.shape(position), overlap=overlap),
            wavenumber,
        )

    def shape(self, position):
        """Return the sines (k, n) at positions (k, 2) [m]."""
        waves = [np.pi * np.array(o) * position / self.sides for o in self.orders]
        return np.stack([np.sin(wave).prod(axis=1) for wave in waves], axis=1)

    def motions(self, patch, vectors=None, stiffness=None) -> Callable[[float, float], np.ndarray]:
        """Return g rms at three points and the rms velocity of a patch, of C_e and m_a."""
        frequency, n = self.frequency, len(self.orders)
        vectors = np.eye(n) if vectors is None else vectors
        if stiffness is None:
            stiffness = self.air(frequency)
            stiffness[:, range(n), range(n)] += self.modal.dynamic_stiffness(frequency)
        else:
            stiffness = stiffness(frequency)[:, :, None] * np.eye(vectors.shape[1])
        middle, node = np.array(patch) * self.sides, np.polynomial.legendre.leggauss(4)
        half = 0.1 * min(self.sides)
        x, y = np.meshgrid(node[0], node[0])
        place = middle + half * np.stack([x.ravel(), y.ravel()], axis=1)
        root = half * np.sqrt(np.outer(node[1], node[1]).ravel())[:, None]
        points = np.array([middle, [0.3 * self.sides[0], 0.2], [0.1, 0.5 * self.sides[1]]])
        felt = root * self.shape(place) @ vectors
        rows = np.concatenate([self.shape(points) @ vectors, felt])
        bare = np.linalg.solve(stiffness, rows.T[None]).swapaxes(1, 2)
        receptance, omega = bare @ felt.T, 2 * np.pi * frequency
        force = vectors.T @ self.force @ vectors
        covariance = bare @ force @ bare.conj().swapaxes(1, 2)

        def rms(damping: float, mass: float) -> np.ndarray:
            s = (1j * omega * damping - omega**2 * mass)[:, None, None]
            update = np.eye(len(rows)) + 0j
            closed = np.linalg.inv(np.eye(len(felt)) + s * receptance[:, 3:])
            update = np.tile(update, (len(omega), 1, 1))
            update[:, :, 3:] -= s * receptance @ closed
            psd = np.einsum(
                "fij,fjk,fik->fi", update, covariance, update.conj(), optimize=True
            ).real
            square = np.trapezoid(omega[:, None] ** 4 * psd[:, :3], frequency, axis=0)
            velocity = np.trapezoid(omega**2 * psd[:, 3:].sum(axis=1), frequency)
            return np.sqrt(np.append(square, velocity))

        return rms


def carried(motion, damping: float, mass: float, velocity: float, gamma: float) -> float:
    """Return the C_e that a panel has of C_e ∝ v^−γ, known at one velocity."""

    def missing(x: float) -> float:
        return x + gamma * np.log(motion(damping * np.exp(x), mass)[3] / velocity)

    return damping * np.exp(brentq(missing, -2.5, 2.5, xtol=1e-4))


def errors(panel: Panel, patch: tuple[float, float]) -> list[tuple[float, np.ndarray]]:
    """Return γ with the errors of g rms and of the rms velocity in the run [1]."""
    loaded = loaded_shapes(panel.modal, panel.extent, panel.air)
    exact = panel.motions(patch)
    run = panel.motions(patch, loaded.vectors, loaded.modal.dynamic_stiffness)
    found = []
    for damping, mass in DAMPERS:
        wanted = exact(damping, mass)
        for gamma in EXPONENTS:
            in_run = carried(run, damping, mass, wanted[3], gamma)
            velocity = run(in_run, mass)[3]
            stated = exact(carried(exact, in_run, mass, velocity, EXPONENT), mass)
            found.append((gamma, np.append(stated[:3], velocity) / wanted - 1))
    return found


def main() -> int:
    """Print the worst errors of each panel and its surroundings."""
    print("panel | surroundings | velocity of runs, % | g rms, %: γ = 0.4 to 1.1 | −1 to 1.1")
    for name, values in PANELS.items():
        for place, wall in SURROUNDINGS.items():
            panel = Panel(*values, wall)
            found = [error for patch in PATCHES for error in errors(panel, patch)]
            near = [100 * np.abs(c[:3]).max() for gamma, c in found if gamma > 0]
            far = [100 * np.abs(c[:3]).max() for _, c in found]
            velocity = [100 * c[3] for gamma, c in found if gamma == 0]
            print(
                f"{name} | {place} | {min(velocity):.1f} to {max(velocity):.1f} | "
                f"{max(near):.2f} | {max(far):.2f}",
                flush=True,
            )
    return 0


if __name__ == "__main__":
    sys.exit(main())
