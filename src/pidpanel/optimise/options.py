"""Dampers on places, with the damping of each frozen at its own consistent motion alone."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.damping.models import FilledDamper
from pidpanel.optimise.reduced_panel import JointPanel, ReducedPanel
from pidpanel.solve.layout import sine_accelerations_g
from pidpanel.solve.receptances import patch_stiffness
from pidpanel.solve.source import interpolated_load

MOTIONS = 16  # Γ at which a damping model is tabulated; linear in ln Γ between them

ROUNDS = 8  # of the search for Γ, each half way in ln Γ: 2⁻⁸ of the first step is left


@dataclass(frozen=True)
class Options:
    """Every filling on every place."""

    # (n_options,) indices
    place: Index
    filling: Index
    mass: Array  # (n_options,) [kg]
    # (n_options, nf) s = iω C_e − ω² m_a [N/m³] on the lines of all parts of a panel
    stiffness: Complexes

    def subset(self, index: Index, used: Index) -> Options:
        """Return some options, with places numbered by those that are used (rising)."""
        place = np.searchsorted(used, self.place[index])
        return Options(place, self.filling[index], self.mass[index], self.stiffness[index])


def frozen_options(
    panel: JointPanel, fillings: Sequence[FilledDamper], factor: float = 1.0
) -> Options:
    """Return every filling on every place of a panel, frozen for each of its parts.

    ``factor`` multiplies the PSD of the excitation.
    """
    count = len(panel.area)
    masses = np.array([filling.mass_per_area for filling in fillings])
    return Options(
        place=np.tile(np.arange(count), len(fillings)),
        filling=np.repeat(np.arange(len(fillings)), count),
        mass=np.outer(masses, panel.area).ravel(),
        stiffness=np.hstack([_frozen(part, fillings, factor) for part in panel.parts]),
    )


def _frozen(panel: ReducedPanel, fillings: Sequence[FilledDamper], factor: float) -> Complexes:
    """Return s (n_options, nf) of each filling alone on each place."""
    count = len(panel.area)
    index = np.arange(count)
    empty = np.zeros((count, panel.frequency.size))
    bare = _motion(panel, index, empty.astype(np.complex64), factor)
    stiffness = []
    for filling in fillings:
        if not filling.depends_on_acceleration:
            value, mass, _ = filling.damping(panel.frequency, np.nan)
            row = patch_stiffness(panel.frequency, value, mass).astype(np.complex64)
            stiffness.append(np.tile(row, (count, 1)))
            continue
        nodes = np.geomspace(bare.min() / 100, 3 * bare.max(), MOTIONS)
        reads = [filling.damping(panel.frequency, node)[:2] for node in nodes.tolist()]
        table = np.array([patch_stiffness(panel.frequency, *read) for read in reads])
        motion = bare
        for _ in range(ROUNDS):
            frozen = interpolated_load(motion, nodes, table).astype(np.complex64)
            motion = np.sqrt(motion * _motion(panel, index, frozen, factor))
        stiffness.append(interpolated_load(motion, nodes, table).astype(np.complex64))
    return np.concatenate(stiffness)


def _motion(panel: ReducedPanel, places: Index, stiffness: Complexes, factor: float) -> Array:
    """Return Γ of each place with a damper on it alone."""
    empty = np.zeros((0, panel.frequency.size), np.complex64)
    square = panel.additions((), empty, places, stiffness).patch_mean_square
    return sine_accelerations_g(np.sqrt(factor * square))
