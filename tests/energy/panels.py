"""Panels for statistical energy."""

import numpy as np

from pidpanel.damping_ratio import DampingRatio
from pidpanel.energy.response import Edges, EnergyPanel, Medium
from pidpanel.energy.waves import PanelWaves
from pidpanel.panel.section import Core, Material, Ply, SandwichSection
from tests.energy.rectangles import SPEED

FACE = (Ply(Material.isotropic(60e9, 0.3, 1600.0), 0.3e-3),)
SANDWICH = SandwichSection(FACE, FACE, Core(186e6, 90e6, 32.0, 0.0244))
SEALED = Medium(SPEED, 1.2, 0, True)  # in a baffle, without air on it


def energy_panel(section, size, *, zeta=0.01, kind="simply_supported", medium=SEALED):
    """A rectangle of one kind of edge."""
    length = np.array([*size, *size])
    edges = Edges(length, np.pi / 2 * np.arange(4), (kind,) * 4)
    waves, ratio = PanelWaves(section), DampingRatio((zeta,))
    return EnergyPanel(waves, float(np.prod(size)), edges, ratio, medium)
