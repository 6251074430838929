"""The paper's panel on a coarse mesh, with one patch, and what moving supports make of it."""

from pathlib import Path
from types import SimpleNamespace

import numpy as np

from pidpanel.base.from_study import write_base
from pidpanel.base.random import interface_force_psd
from pidpanel.base.sine import Transfer, interface_force
from pidpanel.damping_ratio import DampingRatio
from pidpanel.geometry.polygon import Rectangle
from pidpanel.panel.attachments import with_attachments
from pidpanel.panel.basis import basis_of, with_condensed_face
from pidpanel.panel.grid import mesh_quadrilaterals
from pidpanel.panel.section import ThinSection
from pidpanel.panel.shapes import panel_shapes
from pidpanel.panel.thin import assemble_thin_plate
from pidpanel.solve.base_motion import (
    TABLE_MASS,
    BaseExcitation,
    observed_motions,
    supported_panel,
    with_translation,
)
from pidpanel.solve.basis_error import modal_basis
from pidpanel.solve.layout import AttachedDamper, DamperLayout, layouts
from pidpanel.solve.model import ModalBasis, Patches
from pidpanel.solve.panel import ModalPanel
from pidpanel.solve.receptances import patch_stiffness
from pidpanel.structure.from_study import write_panel
from pidpanel.study import load_study
from tests.jobs import PANEL, files, within

HERE = Path(__file__).parent
SIZE, STIFFNESS, MASS_PER_AREA, RATIO = (1.5, 1.0), 3273.07, 4.0, 0.02
POINTS = {"centre": (0.7, 0.5), "aside": (0.3, 0.3)}
MASS = MASS_PER_AREA * SIZE[0] * SIZE[1]
DAMPING, APPARENT = 600.0, 3.0
HIGHEST = 400.0
POINT_MASS = 0.7
WHITE = 2.0
CARRIED, NATURAL, ZETA, LEVEL = 3.0, 50.0, 0.05, 2.0
"""Of an oscillator [kg, Hz, 1] and PSD of the acceleration of its base [(m/s²)²/Hz]."""


def panel_of(path, attachments=(), elements=(15, 10), points=POINTS):
    patch = {"PID-1": Rectangle((0.7, 0.5), (0.4, 0.2))}
    mesh = mesh_quadrilaterals(path / "panel.msh", SIZE, elements, patch, points)
    plate = assemble_thin_plate(mesh, ThinSection(STIFFNESS, MASS_PER_AREA))
    plate = with_attachments(plate, attachments, mesh)
    shapes = panel_shapes(plate, 2 * HIGHEST)
    stored = plate.with_shapes(shapes.vectors)
    mass = MASS_PER_AREA * SIZE[0] * SIZE[1] + sum(item.mass for item in attachments)
    none = np.zeros((shapes.vectors.shape[0], 0))
    basis = with_condensed_face(basis_of(mesh, plate, shapes), 40.0)
    supported = supported_panel(basis, stored, none, HIGHEST, mass)
    wide = with_translation(supported.basis, supported.inertia)
    return SimpleNamespace(
        supported=supported,
        plate=stored,
        inertia=supported.inertia,
        basis=wide,
        modal=modal_basis(wide, DampingRatio((RATIO,)), HIGHEST),
        patches=Patches(wide.patch_overlap, [0.4 * 0.2]),
        observed=observed_motions(wide, supported.inertia),
        excitation=BaseExcitation.of_inertia(lambda f: np.full(f.shape, WHITE), supported.inertia),
    )


def transfer_of(panel, frequency):
    rows = panel.observed.reshape(-1, panel.observed.shape[2])
    return Transfer.of_panel(frequency, panel.modal, panel.patches, panel.excitation.force, rows)


def solved(panel, frequency, damping=0.0, mass=0.0):
    """Motions (nf, n_points + 1, m) and force (nf,) per acceleration, and the transfer."""
    transfer = transfer_of(panel, frequency)
    s = patch_stiffness(frequency, *np.full((2, 1, frequency.size), [[[damping]], [[mass]]]))
    motion = transfer.motions(s)
    motion = motion.reshape(len(frequency), *panel.observed.shape[:2])
    return motion, interface_force(frequency, motion[:, -1], [0], s), transfer


def oscillator(frequency, damping=0.0, mass=0.0):
    """(nf,) PSDs of absolute acceleration and force with a dashpot [N s/m] and mass [kg] on it."""
    area = 1.0
    basis = ModalBasis([NATURAL, 0.0], [CARRIED, TABLE_MASS * CARRIED], [ZETA, ZETA])
    patches = Patches(np.ones((1, 2, 2)), [area])
    excitation = BaseExcitation(
        lambda f: np.full(f.shape, LEVEL), np.array([-CARRIED, TABLE_MASS * CARRIED])
    )
    points = np.zeros((2, 2, 2))
    points[0] = [[1, 1], [1, 0]]
    points[1] = [[CARRIED, CARRIED], [area, area]]
    panel = ModalPanel(basis, patches, frequency, points, frequency)
    load = AttachedDamper(0, lambda f, _gamma: (0 * f + damping, 0 * f + mass, f > 0), False)
    (answer,) = layouts(panel, excitation, [DamperLayout((load,) if damping or mass else ())])
    cross = answer.response.cross_psd
    force = interface_force_psd(answer, cross[:, 1])
    omega = 2 * np.pi * frequency
    return omega**4 * cross[:, 0, 0, 0].real, omega**4 * cross[:, 0, 1, 1].real, force


def shaken_study(folder):
    """A study of which the stages up to the base are run, and the folder of the last."""
    study = load_study(HERE / "shaken.yaml")
    return study, run_stages(study, folder)


def run_stages(study, folder):
    """Run the panel and the base of a study without coupons; return the folder of the base."""
    panel, base = folder / "panel", folder / "base"
    panel.mkdir()
    base.mkdir()
    read = files(within(panel, PANEL))
    write_panel(study, read)
    output = {
        "modes_table": "modes.csv", "summary": "summary.csv", "psd": "psd.nc",
        "psd_table": "psd.csv",
        "notched": "notched.csv", "sine_table": "sine.csv", "sine": "sine.nc",
    }  # fmt: skip
    write_base(study, read, None, files(within(base, output)))
    return base
