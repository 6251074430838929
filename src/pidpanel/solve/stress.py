"""Strain and stress at points of the panel from the cross-PSDs of its motion.

A `PanelResponse` whose motions are (w, κ_xx, κ_yy, κ_xy, γ_xz, γ_yz) knows every strain and stress
that the section makes of them: ε = E κ and σ = S κ in a layer, τ = T γ in the core, with the
matrices of `pidpanel.panel.section`, so that S_ε = E S_κ Eᵀ and so on.

The von Mises stress σ_v² = σᵀ A σ of a plane state is a quadratic form, whose mean is

    E[σ_v²] = ∫ tr(A S_σ) df,    A = [[1, −½, 0], [−½, 1, 0], [0, 0, 3]]

(Segalman, Fulcher, Reese and Field, J. Sound Vib. 230 (2000) 393-410): it depends on correlations
between the components, so the three rms values are not enough. The components are Gaussian with
zero mean, so three times the rms is exceeded 0.27 % of the time. The von Mises stress is neither,
and three times its rms is a custom of design without such a probability.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.solve.model import PanelResponse

# A of σ_v² = σᵀ A σ for σ = (σ_xx, σ_yy, τ_xy).
VON_MISES = np.array([[1.0, -0.5, 0.0], [-0.5, 1.0, 0.0], [0.0, 0.0, 3.0]])

# What `layer_psd` returns, with units; strain_xy is the engineering shear strain.
QUANTITIES = {
    **dict.fromkeys(("strain_xx", "strain_yy", "strain_xy"), "1"),
    **dict.fromkeys(("stress_xx", "stress_yy", "stress_xy", "von_mises"), "Pa"),
}

# What `core_psd` returns
CORE_STRESSES = ("core_shear_xz", "core_shear_yz")
CORE_QUANTITIES = dict.fromkeys(CORE_STRESSES, "Pa")


@dataclass(frozen=True)
class Layers:
    """Layers of a section, each kind of motion once."""

    # (n_layers,) such as "top and bottom" where the two differ by sign alone
    names: tuple[str, ...]
    # (n_layers, 3, 3) strain [m] and stress [Pa m] per curvature; of a shell (n_layers, 3, 6)
    strain: Array
    stress: Array


def distinct_layers(names: Sequence[str], strain: Array, stress: Array) -> Layers:
    """Join the layers whose strain and stress differ by sign alone: their PSDs are one.

    Examples
    --------
    >>> layers = distinct_layers(["top", "bottom"], *[np.stack([np.eye(3), -np.eye(3)])] * 2)
    >>> layers.names, layers.strain.shape
    (('top and bottom',), (1, 3, 3))
    """
    scaled = [
        m / np.max(np.abs(m), initial=0.0) for m in (strain, stress)
    ]  # so that rounding is 1e-16
    distinct: list[int] = []
    joined: list[str] = []
    for index, name in enumerate(names):
        for place, previous in enumerate(distinct):
            if any(
                all(np.allclose(m[index], sign * m[previous], rtol=1e-9) for m in scaled)
                for sign in (1, -1)
            ):
                joined[place] += f" and {name}"
                break
        else:
            distinct.append(index)
            joined.append(name)
    return Layers(tuple(joined), strain[distinct], stress[distinct])


def layer_psd(response: PanelResponse, layers: Layers) -> Array:
    """Return PSDs of strain and stress in every layer at every point.

    Parameters
    ----------
    response
        Response with the motions (w, κ_xx, κ_yy, κ_xy, …) at its points.

    Returns
    -------
    (nf, n_points, n_layers, 7) in the order and units² of `QUANTITIES`, per Hz.
    """
    von_mises = layers.stress.swapaxes(1, 2) @ VON_MISES @ layers.stress
    forms = [_squares(layers.strain), _squares(layers.stress), von_mises[:, None]]
    rows = slice(1, 1 + layers.strain.shape[2])
    return _means(np.concatenate(forms, axis=1), response.cross_psd[:, :, rows, rows])


def core_psd(response: PanelResponse, core_stress: Array) -> Array:
    """Return PSDs of the shear stresses in the core.

    Parameters
    ----------
    response
        Response with the motions (w, κ_xx, κ_yy, κ_xy, γ_xz, γ_yz) at its points.
    core_stress
        (2, 2) shear stress per shear angle [Pa].

    Returns
    -------
    (nf, n_points, 2) [Pa²/Hz].
    """
    return _means(_squares(core_stress), response.cross_psd[:, :, -2:, -2:])


def _squares(matrix: Array) -> Array:
    """Return the quadratic forms (…, n, m, m) of the components of matrix (…, n, m) times κ."""
    return matrix[..., :, None] * matrix[..., None, :]


def _means(forms: Array, psd: Complexes) -> Array:
    """Return tr(F S) of symmetric F (…, m, m) and S (nf, n_points, m, m)."""
    flat = forms.reshape(*forms.shape[:-2], forms.shape[-1] ** 2)
    return np.tensordot(psd.real.reshape(*psd.shape[:2], flat.shape[-1]), flat, axes=(2, -1))
