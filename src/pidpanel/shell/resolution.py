"""Size of the elements of a shell, and the error of frequencies that they make.

Displacements of order p are among those of order p + 1, so each frequency falls from one order to
the next. Waves converge faster than any power of p; the layers along edges of sandwiches and plates
with shear, and corners, at least as 1/p. So what is left beyond order p + 2 is at most p + 1 times
the last fall, and the error of order p is at most the first fall and p + 2 times the second.
"""

from collections.abc import Mapping

import numpy as np

from pidpanel.arrays import Array
from pidpanel.panel.modes import normal_modes
from pidpanel.shell.assembly import NOTHING, Attached, assemble_shell
from pidpanel.shell.mesh import ShellMesh
from pidpanel.shell.strains import Layup, frames

EDGE = 0.35  # length of edges over the shortest wave of bending
FLAT = 1e-6  # extent over the radius of a flat surface, by rounding
KINK = 0.35  # angle between facets [rad] above which an edge is a kink
# Distance of a surface from its facets over the thickness: 0.16 made frequencies of a cylinder 1 %
# too low, 0.07 0.3 %.
MOST_BULGE = 0.07
LAYER = 3.0  # length of edges over √(R h), the depth of the layers along the edges of thin shells


def element_size(layup: Layup, highest: float, radius: float = np.inf) -> float:
    """Return the length of edges [m] for modes below a frequency [Hz].

    Waves are those of the flat section in its softer direction, k⁴ D = m″ω² (1 + k² D/S); those of
    a curved one are longer. Frequencies are then mostly within 0.2 %.

    Parameters
    ----------
    radius
        Smallest radius of curvature [m]; see `smallest_radius`. Without it edges are too long for
        thin shells, whose frequencies were up to 6 % too high.
    """
    C = layup.stiffness
    reduced = C[3:6, 3:6] - C[3:6, :3] @ np.linalg.solve(C[:3, :3], C[:3, 3:6])
    D, S = min(reduced[0, 0], reduced[1, 1]), min(C[6, 6], C[7, 7])
    inertia = layup.density[0] * (2 * np.pi * highest) ** 2
    shear = inertia / (2 * S)
    wave = 2 * np.pi / np.sqrt(shear + np.sqrt(shear**2 + inertia / D))
    return float(min(EDGE * wave, LAYER * np.sqrt(radius * bending_thickness(layup))))


def smallest_radius(mesh: ShellMesh) -> float:
    """Return the smallest radius of curvature at the middle of an element [m]; ∞ if it is flat."""
    middle = np.full((1, 2), 1 / 3)
    bend = frames(mesh, 1, middle, np.arange(len(mesh.cells)), None).curvature
    largest = float(np.abs(np.linalg.eigvalsh((bend + bend.swapaxes(2, 3)) / 2)).max())
    return 1 / largest if largest > FLAT / mesh.extent else np.inf


def bulge(mesh: ShellMesh) -> float:
    """Return how far a smooth surface stands off the flat facets of a mesh [m]; 0 of curved ones.

    Two facets that meet at an angle θ are chords of an arc, off by θ h/8 with h across their edge.
    Edges of more than `KINK` are kinks of the structure.
    """
    if mesh.order > 1:
        return 0.0
    corners = mesh.vertices[mesh.cells]
    normal = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    sides = mesh.cells[:, [[0, 1], [1, 2], [2, 0]]].reshape(-1, 2)
    _, edge, count = np.unique(
        np.sort(sides, axis=1), axis=0, return_inverse=True, return_counts=True
    )
    order = np.argsort(edge.ravel(), kind="stable")
    pairs = order[count[edge.ravel()[order]] == 2].reshape(-1, 2)
    twice_area = np.linalg.norm(normal, axis=1)
    unit = (normal / twice_area[:, None])[pairs // 3]
    angle = np.arcsin(np.clip(np.linalg.norm(np.cross(unit[:, 0], unit[:, 1]), axis=1), 0, 1))
    length = np.linalg.norm(np.diff(mesh.vertices[sides[pairs[:, 0]]], axis=1)[:, 0], axis=1)
    height = twice_area[pairs // 3].mean(axis=1) / length
    is_smooth = (angle < KINK) & ((unit[:, 0] * unit[:, 1]).sum(axis=1) > 0)
    return float((angle * height / 8)[is_smooth].max(initial=0.0))


def bending_thickness(layup: Layup) -> float:
    """Return the thickness √(12 D/A) of a plate as stiff in bending and stretching [m]."""
    C = layup.stiffness
    reduced = C[3:6, 3:6] - C[3:6, :3] @ np.linalg.solve(C[:3, :3], C[:3, 3:6])
    return float(np.sqrt(12 * min(reduced[0, 0], reduced[1, 1]) / max(C[0, 0], C[1, 1])))


def layer_depth(layup: Layup) -> float:
    """Return √(D₆₆/S), the depth of the layer in which shear relieves twist at free edges [m]."""
    C = layup.stiffness
    return float(np.sqrt(C[5, 5] / min(C[6, 6], C[7, 7])))


def frequency_shifts(
    mesh: ShellMesh,
    layup: Layup | Mapping[str, Layup],
    attached: Mapping[str, Attached] = NOTHING,
    *,
    frequency: Array,
    order: int = 4,
) -> Array:
    """Return by how much the frequencies of modes are too high at most (n,) [1].

    Parameters
    ----------
    mesh, layup, attached, order
        Same as in `assemble_shell`.
    frequency
        (n,) of the modes of that order [Hz], ascending, from the first.
    """
    lower = [frequency]
    for further in (1, 2):
        shell = assemble_shell(mesh, layup, attached, order + further)
        found, _ = normal_modes(shell, float(frequency[-1]), len(frequency))
        lower.append(found[: len(frequency)])
    first, second = -np.diff(lower, axis=0)
    fall = np.maximum(first + (order + 2) * second, 0.0)
    return np.divide(fall, frequency, out=np.zeros_like(fall), where=frequency > 0)
