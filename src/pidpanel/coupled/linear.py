"""The panel with linear dampers over frequency, see `solve.receptances`.

Dampers exert iωL u at the motions u = Eᵀq. At the simulated cells E has their shapes as columns and
L = diag(a_c Z_c); of whole patches D_p = E_p E_pᵀ and L = diag(Z_p). An own force n of the
particles acts on the modes as −Σ φ n a.
"""

from collections.abc import Callable, Sequence

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.excitation import Matrices
from pidpanel.solve.modal import chunks_of_lines
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.moved_panel import CoupledShapes, MovedPanel
from pidpanel.solve.receptances import Receptances

# Frequencies (nf,) [Hz] → a matrix of the shapes at each (nf, n, n): the cross-PSD of modal forces
# [N²/Hz], or a dynamic stiffness [N/m].
OverFrequency = Callable[[Array], Matrices]


def linear_motion(
    frequency: Array,
    modal: ModalBasis,
    added: OverFrequency | None,
    felt: Array,
    observed: Array,
    load: Complexes,
    amplitude: Complexes,
) -> Complexes:
    """Return the motions Wᵀq (nf, s) [m] under modal forces (nf, n).

    Parameters
    ----------
    added
        Dynamic stiffness of the air; None in vacuum.
    felt, observed
        (n, r) E and (s, n) Wᵀ [1].
    load
        (nf, r) diagonal of L.
    """
    motions = np.empty((len(frequency), len(observed)), complex)
    for lines in chunks_of_lines(len(frequency), len(felt)):
        f, force = frequency[lines], amplitude[lines, :, None]
        moved = MovedPanel(f, modal, _coupled(added, f, felt), [felt, observed.T])
        free = (moved.under(part, force)[:, :, 0] for part in (0, 1))
        panel = Receptances(*moved.receptances(0, [0, 1]))
        motions[lines] = panel.motions(_pull(f, load[lines]), *free)
    return motions


def linear_psds(
    frequency: Array,
    modal: ModalBasis,
    added: OverFrequency | None,
    felt: Array,
    observed: Array,
    sets: Sequence[tuple[Complexes, OverFrequency]],
) -> Array:
    """Return the PSDs (sets, nf, s) [m²/Hz] of the motions Wᵀq, of several loads and forces.

    Parameters are those of `linear_motion`.
    """
    psds = np.empty((len(sets), len(frequency), len(observed)))
    forces = {id(force): force for _, force in sets}
    for lines in chunks_of_lines(len(frequency), len(felt)):
        f, panels = frequency[lines], {}
        moved = MovedPanel(f, modal, _coupled(added, f, felt), [felt, observed.T])
        for key, force in forces.items():
            G = force(f)
            free = np.einsum("fii->fi", moved.psds(1, [1], G)[0]).real
            receptances = moved.receptances(0, [0, 1])
            panels[key] = Receptances(*receptances, *moved.psds(0, [0, 1], G)), free
        for psd, (load, force) in zip(psds, sets, strict=True):
            panel, free = panels[id(force)]
            psd[lines] = free - panel.reaction(_pull(f, load[lines])).taken
    return psds


def _coupled(added: OverFrequency | None, frequency: Array, felt: Array) -> CoupledShapes | None:
    """Return all shapes: dampers may be among what couples them."""
    return added and CoupledShapes(np.arange(len(felt)), added(frequency))


def _pull(frequency: Array, load: Complexes) -> Complexes:
    return 2j * np.pi * frequency[:, None] * load
