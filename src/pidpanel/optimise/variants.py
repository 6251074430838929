"""Layouts on panels and under excitations that differ from the stated ones, as in the search.

Beside them the mass of a layout spent on the panel itself: thicker face sheets, or a damping layer.
Either is spread over the whole panel, so that its modes keep their shapes.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.models import FilledDamper
from pidpanel.optimise.options import frozen_options
from pidpanel.optimise.reduced_panel import JointPanel
from pidpanel.optimise.search import Layout, Problem
from pidpanel.solve.model import ModalBasis

LEVELS_DB = (-6.0, 6.0)  # changes of the level of the excitation

DAMPING_FACTORS = (0.5, 2.0)  # on the damping ratio of the panel

MASS_FACTORS = (0.9, 1.1)  # on C_e and m_a: the tolerance of the mass that is filled in

FACE_SHARE = 0.5  # share of the face sheets in the mass of a panel whose section does not state it

VARIANTS = (
    *(f"level_{level:+g}_db" for level in LEVELS_DB),
    *(f"damping_ratio_x{factor:g}" for factor in DAMPING_FACTORS),
    *(f"damper_mass_x{factor:g}" for factor in MASS_FACTORS),
)


def reductions(
    problem: Problem,
    fillings: Sequence[FilledDamper],
    layouts: Sequence[Layout],
    panel_with: Callable[[float], JointPanel],
) -> Array:
    """Return the reduction of the objective of each layout with each of `VARIANTS`.

    The damping is frozen at the motion of each damper alone in the variant.

    Parameters
    ----------
    panel_with
        Factor on the damping ratio → the panel with the places of the problem.

    Returns
    -------
    (n_layouts, n_variants) [dB].
    """
    varied = [
        replace(problem, options=frozen_options(problem.panel, fillings, 10 ** (level / 10)))
        for level in LEVELS_DB
    ]
    for factor in DAMPING_FACTORS:
        panel = panel_with(factor)
        varied.append(replace(problem, panel=panel, options=frozen_options(panel, fillings)))
    for factor in MASS_FACTORS:
        options = problem.options
        scaled = replace(options, stiffness=np.complex64(factor) * options.stiffness)
        varied.append(replace(problem, options=scaled))
    columns = []
    for variant in varied:
        variant = replace(variant, evaluated={})
        bare = float(variant.objective(variant.panel.bare))
        squares = [float(variant.objective(variant.mean_square(layout))) for layout in layouts]
        columns.append(10 * np.log10(bare / np.array(squares)))
    return np.stack(columns, axis=1)


def thicker_faces(modal: ModalBasis, share: float) -> ModalBasis:
    """Return the modes with a share of the panel's mass added to its face sheets.

    The bending stiffness grows as the thickness of thin face sheets, by ``share / FACE_SHARE``.
    """
    mass, stiffness = 1 + share, 1 + share / FACE_SHARE
    frequency = modal.natural_frequency * np.sqrt(stiffness / mass)
    return ModalBasis(frequency, mass * modal.modal_mass, modal.damping_ratio)


def damped_by_layer(modal: ModalBasis, share: float, loss_factor: float) -> ModalBasis:
    """Return the modes with a layer that adds a share of mass and a loss factor 2 Δζ."""
    mass = 1 + share
    frequency = modal.natural_frequency / np.sqrt(mass)
    return ModalBasis(frequency, mass * modal.modal_mass, modal.damping_ratio + loss_factor / 2)
