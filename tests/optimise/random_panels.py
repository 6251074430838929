"""Small panels drawn at random, with places on them and dampers to choose from."""

import itertools

import numpy as np
import shapely

from pidpanel.damping.models import Damper, DampingValues, FilledDamper
from pidpanel.optimise.objectives import accelerations
from pidpanel.optimise.options import frozen_options
from pidpanel.optimise.places import places_on
from pidpanel.optimise.reduced_panel import JointPanel, ReducedPanel
from pidpanel.optimise.search import Problem
from pidpanel.solve.base_motion import TABLE_MASS, BaseExcitation
from pidpanel.solve.excitation import ModalForce
from pidpanel.solve.model import ModalBasis, Patches


class Falling(Damper):
    """C_e that falls with the motion, as that of particles."""

    depends_on_acceleration = True

    def __init__(self, damping, mass):
        self.damping, self.mass = damping, mass

    def __call__(self, frequency, fill_fraction, gamma):
        value = self.damping * (1 if np.isnan(gamma) else (1 + gamma) ** -0.5)
        every = np.ones(frequency.shape)
        return DampingValues(value * every, 0 * every, self.mass * every, every > 0)

    def mass_per_area(self, fill_fraction):
        return self.mass


class RandomPanel:
    """A simply supported plate with places, under random forces of a falling spectrum.

    On a moving base its last shape is the translation, and the supports have that spectrum.
    """

    def __init__(self, seed, heavy=False, moving=False, lines=160):
        self.moving = moving
        draw = np.random.default_rng(seed)
        self.size = draw.uniform([0.9, 0.6], [1.6, 1.1])
        self.per_area = draw.uniform(3, 6)
        self.modes = [(m, n) for m in range(1, 6) for n in range(1, 5)]
        root = np.sqrt(draw.uniform(500, 4000) / self.per_area)
        frequency = [
            np.pi / 2 * root * ((m / self.size[0]) ** 2 + (n / self.size[1]) ** 2)
            for m, n in self.modes
        ]
        mass = np.full(len(self.modes), self.per_area * self.size.prod() / 4)
        ratio, whole = draw.uniform(0.008, 0.03), self.per_area * self.size.prod()
        if moving:
            frequency, mass = [*frequency, 0.0], np.append(mass, TABLE_MASS * whole)
        self.basis = ModalBasis(frequency, mass, ratio)
        hole = shapely.box(*(self.size * 0.4), *(self.size * draw.uniform(0.5, 0.6, 2)))
        side = tuple(self.size / 4)
        area = shapely.box(0, 0, *self.size)
        self.places = places_on(area, side, tuple(self.size / draw.integers(4, 6)), [hole])
        self.patches = Patches(
            np.stack([self.overlap(lower, side) for lower in self.places.lower]),
            self.places.area,
        )
        position = draw.uniform(0.1, 0.9, (3, 2)) * self.size
        self.points = self.shape(position)
        load = draw.normal(size=(len(self.modes), 40))
        self.slope = draw.uniform(0, 2)
        self.force = load @ load.T / 40 * self.size.prod() ** 2
        self.frequency = np.geomspace(20, 1.2 * max(frequency), lines)
        self.excitation = ModalForce(self.spectrum, self.force)
        if moving:
            of_wave = {number: (1 - (-1) ** number) / (np.pi * number) for number in range(1, 6)}
            pull = [-whole * of_wave[m] * of_wave[n] for m, n in self.modes]
            self.excitation = BaseExcitation(self.spectrum, np.array([*pull, mass[-1]]))
        scale = (40 if heavy else 1) * self.per_area
        self.fillings = [
            self.filling(f"damper {k}", *draw.uniform([30, 0.05], [900, 0.5]) * [1, scale])
            for k in range(2)
        ]
        self.budget = draw.uniform(1, 3) * max(f.mass_per_area for f in self.fillings)
        self.budget *= self.places.area[0]

    def spectrum(self, frequency):
        return (frequency / 100) ** -self.slope

    def shape(self, position):
        x, y = np.asarray(position, float).T
        a, b = self.size
        waves = [np.sin(m * np.pi * x / a) * np.sin(n * np.pi * y / b) for m, n in self.modes]
        return np.stack([*waves, np.ones(len(x))] if self.moving else waves, axis=1)

    def overlap(self, lower, side, order=16):
        node, weight = np.polynomial.legendre.leggauss(order)
        x, y = np.meshgrid(*(lo + s * (1 + node) / 2 for lo, s in zip(lower, side, strict=True)))
        shape = self.shape(np.stack([x.ravel(), y.ravel()], axis=1))
        return shape.T @ (np.outer(weight, weight).ravel()[:, None] * np.prod(side) / 4 * shape)

    def filling(self, name, damping, mass):
        return FilledDamper(name, Falling(damping, mass))

    def reduced(self, **more):
        return ReducedPanel(
            self.frequency, self.basis, self.patches, self.points, self.excitation, **more
        )

    def problem(self, most=3, is_largest=True):
        outputs = accelerations(np.arange(3), is_largest=is_largest).outputs(self.frequency)
        panel = JointPanel((self.reduced(rank=4, outputs=outputs),))
        options = frozen_options(panel, self.fillings)
        return Problem(panel, options, self.places, self.budget, most)


def problems(sound, base, most=2, is_largest=True):
    """The problems of one panel under sound, on a base and under both at once.

    Places and dampers of both are those under sound.
    """
    alone = [each.problem(most, is_largest) for each in (sound, base)]
    panel = JointPanel(tuple(problem.panel.parts[0] for problem in alone))
    options = frozen_options(panel, sound.fillings)
    return *alone, Problem(panel, options, alone[0].places, sound.budget, most)


def exhaustive(problem):
    """The least that counts over all layouts within the limits."""
    best = float(problem.objective(problem.panel.bare))
    count = problem.options.mass.size
    for size in range(problem.max_patches):
        for layout in itertools.combinations(range(count), size):
            later = np.arange(count) > max(layout, default=-1)
            is_feasible = all(
                problem.feasible(layout[:k])[option] for k, option in enumerate(layout)
            )
            if is_feasible:
                best = min(best, problem.objective(problem.additions(layout, later)).min())
    return best
