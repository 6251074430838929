"""The basis of a panel in one step, as many tests need it."""

from pidpanel.panel.basis import basis_of
from pidpanel.panel.shapes import panel_shapes


def panel_basis(mesh, plate, frequency_limit, *options):
    """Modes below a frequency and the shapes that the patches of the mesh need."""
    return basis_of(mesh, plate, panel_shapes(plate, frequency_limit, *options))
