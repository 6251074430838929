"""Strain and stress of the faces and the core from the shapes of a basis.

The basis carries the curvature and the shear angle of every shape at the vertices and at the
response points, and for every layer of the section what strain and stress a curvature means.
Everything is linear: whoever has the modal coordinates q of a motion gets a stress as
``stress_at(basis, layer)[0][position] @ q``.

At vertices, curvatures are means over the cells that meet there; at re-entrant corners and under
point supports the plate's own curvature has no bound, and neither has what is read there.
"""

import numpy as np
from numpy.typing import NDArray

from pidpanel.panel.modes import PanelBasis

Array = NDArray[np.float64]


def strain_shapes(basis: PanelBasis, layer: str, where: str = "points") -> Array:
    """Strain of a layer per unit of each shape.

    Parameters
    ----------
    basis : PanelBasis
    layer : str
        One of ``basis.layer_names``.
    where : str
        "points" or "vertices".

    Returns
    -------
    ndarray, shape (n_positions, 3, n)
        (e_1, e_2, g_12) in the layer's axes, per unit of modal coordinate [-].

    Raises
    ------
    ValueError
        If the section has no such layer.
    """
    return _of_layer(basis, basis.layer_strain, layer, where)


def stress_shapes(basis: PanelBasis, layer: str, where: str = "points") -> Array:
    """Stress of a layer per unit of each shape; parameters as `strain_shapes`.

    Returns
    -------
    ndarray, shape (n_positions, 3, n)
        (s_1, s_2, t_12) in the layer's axes, per unit of modal coordinate [Pa].
    """
    return _of_layer(basis, basis.layer_stress, layer, where)


def core_stress_shapes(basis: PanelBasis, where: str = "points") -> Array:
    """Shear stress (t_xz, t_yz) of the core per unit of each shape; zero for a thin plate.

    Returns
    -------
    ndarray, shape (n_positions, 2, n)
        [Pa].
    """
    shear = basis.shear_at_points if where == "points" else basis.shear_at_vertices
    return np.einsum("ij,pjn->pin", basis.core_stress, shear)


def _of_layer(basis: PanelBasis, matrices: Array, layer: str, where: str) -> Array:
    if layer not in basis.layer_names:
        raise ValueError(f"no layer {layer!r}; the section has {', '.join(basis.layer_names)}")
    curvature = basis.curvature_at_points if where == "points" else basis.curvature_at_vertices
    return np.einsum("ij,pjn->pin", matrices[basis.layer_names.index(layer)], curvature)
