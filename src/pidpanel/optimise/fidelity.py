"""How finely a search sees the panel: lines, motions of each place, static response to places.

A heavy damper moves what the bare panel hardly shows: it bends the panel under it more than the
modes below twice the highest frequency can, in more than a few motions, and its mass lowers the
damping ratio of resonances. A search begins coarse. The layouts that it proposes are solved again
with the same damping at `DETAILED`, and while they differ by more than `AGREED` it is repeated at
the next of `FIDELITIES`.
"""

from collections.abc import Sequence
from dataclasses import replace
from typing import NamedTuple

import numpy as np

from pidpanel.damping.models import FilledDamper
from pidpanel.optimise.excitations import STATIC_TOLERANCE
from pidpanel.optimise.objectives import Objective
from pidpanel.optimise.places import PlacedPanel
from pidpanel.optimise.reduced_panel import ReducedPanel
from pidpanel.solve.base_motion import BaseExcitation
from pidpanel.solve.lines import frequency_grid, smallest_damping_ratio
from pidpanel.solve.model import ModalBasis

LINES_PER_BANDWIDTH = 2.0  # of the bare panel: g rms within 0.2 %

AGREED = 0.1  # largest difference between a search and `DETAILED` [dB]


class Fidelity(NamedTuple):
    """How finely a search sees the panel."""

    loaded_lines: float  # least number to a half-power bandwidth of the panel with dampers
    rank: int  # motions of each place; 4 with light dampers: g rms within 0.2 %
    static_tolerance: float  # see `excitations.static_shapes`; 1 for no static response


FIDELITIES = (Fidelity(1.0, 4, 1.0), Fidelity(1.5, 8, 0.1), Fidelity(2.0, 12, 0.03))

DETAILED = Fidelity(2.0, 12, STATIC_TOLERANCE)


def first_fidelity(
    panels: Sequence[PlacedPanel], fillings: Sequence[FilledDamper], mass: float
) -> int:
    """Return where a search begins in `FIDELITIES`: not with lines that miss resonances.

    Parameters
    ----------
    fillings
        Dampers to choose from. One that follows the motion is taken to damp enough.
    mass
        Mass of all dampers [kg].
    """
    constant = [filling for filling in fillings if not filling.depends_on_acceleration]
    lines = FIDELITIES[0].loaded_lines
    return int(any(_line_ratio(p, constant, mass, lines) < _bare_ratio(p) for p in panels))


def reduced(
    panel: PlacedPanel,
    objective: Objective,
    fidelity: Fidelity,
    fillings: Sequence[FilledDamper] = (),
    mass: float = 0.0,
    modal: ModalBasis | None = None,
) -> ReducedPanel:
    """Return the panel of a search with the outputs of its objective.

    Parameters
    ----------
    fillings, mass
        Dampers to choose from, and the mass of all of them [kg], for the lines.
    modal
        Other modes of the same shapes; by default those of the panel.
    """
    settings, excitation, modal = panel.settings, panel.excitation, modal or panel.modal
    if isinstance(excitation, BaseExcitation):
        ratio = modal.modal_mass / panel.modal.modal_mass  # forces of inertia go with the masses
        excitation = replace(excitation, force=ratio * excitation.force)
    lines = frequency_grid(
        *settings.frequency_range,
        _line_ratio(panel, fillings, mass, fidelity.loaded_lines),
        jumps=settings.jumps,
        lines_per_bandwidth=LINES_PER_BANDWIDTH,
    )
    return ReducedPanel(
        lines, modal, panel.patches, objective.rows(panel.motion_at_points),
        excitation, panel.air, outputs=objective.outputs(lines), rank=fidelity.rank,
    )  # fmt: skip


def _bare_ratio(panel: PlacedPanel) -> float:
    settings = panel.settings
    return settings.damping_ratio.smallest(*settings.frequency_range)


def _line_ratio(
    panel: PlacedPanel, fillings: Sequence[FilledDamper], mass: float, loaded_lines: float
) -> float:
    """Return ζ whose bandwidth has `LINES_PER_BANDWIDTH` lines."""
    loaded = least_loaded_ratio(panel, fillings, mass) * LINES_PER_BANDWIDTH / loaded_lines
    return min(
        _bare_ratio(panel), max(loaded, smallest_damping_ratio(*panel.settings.frequency_range))
    )


def least_loaded_ratio(panel: PlacedPanel, fillings: Sequence[FilledDamper], mass: float) -> float:
    """Return the smallest ζ of a mode whose antinode carries the mass [kg] of all dampers.

    By Rayleigh's quotient with the shapes of the bare panel: with ν the kinetic energy of the mass
    over that of the panel, at most m_a/m″, ω_i²/(1 + ν) and ζ_i/√(1 + ν) + the part of C_e. What
    follows the motion counts without damping. ∞ where no mode comes within the range.
    """
    low, high = panel.settings.frequency_range
    modal, patches = panel.modal, panel.patches
    elastic = modal.natural_frequency > 0
    omega, modal_mass = modal.angular_frequency[elastic], modal.modal_mass[elastic]
    moved = (patches.diagonal / patches.area[:, None]).max(axis=0)[elastic]
    smallest = np.inf
    for filling in fillings:
        share = np.minimum(mass * moved / modal_mass, filling.mass_per_area / panel.mass_per_area)
        loaded = omega / np.sqrt(1 + share)
        ratio = modal.damping_ratio[elastic] / np.sqrt(1 + share)
        if not filling.depends_on_acceleration:
            damping, _, _ = filling.damping(loaded / (2 * np.pi), np.nan)
            ratio = ratio + damping / filling.mass_per_area * share / (2 * (1 + share) * loaded)
        inside = (loaded >= 2 * np.pi * low) & (loaded <= 2 * np.pi * high)
        smallest = min(smallest, float(ratio[inside].min(initial=np.inf)))
    return smallest
