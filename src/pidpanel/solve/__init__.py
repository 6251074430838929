"""The response of a panel with layouts of dampers: arrays only, no study and no path.

`model`, `modal`, `moved_panel`
    Checked inputs; the bare panel in modal coordinates, line by line.
`excitation`, `panel`
    What drives a panel; a panel with patches and points.
`receptances`, `dampers`
    Receptances with dampers on; those of patches attached, also in the paper's diagonal form.
`layout`, `solvers`
    `layouts`, the one entry: any number of layouts on a panel under an excitation.
`search`, `motions`
    The consistent motion: the Γ at which the motions of all patches and their damping agree.
`elements`, `basis_error`
    All elements compared with the basis, and the error of the basis.
`uncertainty`
    Standard errors of C_e and m_a carried to PSDs and rms values.
`power`, `sharpness`, `lines`, `bands`
    Balance of power, sharpest resonance, frequency lines, third octaves.
`stress`, `maps`
    Strain and stress; rms values over the whole panel.
`source`
    The force of the particles that is not linear in the motion.
"""

from pidpanel.solve.layout import layouts

__all__ = ["layouts"]
