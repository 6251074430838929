"""Surfaces from files of gmsh and CAD."""

import gmsh
import pytest

from pidpanel.panel.mesh import gmsh_session
from pidpanel.shell.assembly import assemble_shell
from pidpanel.shell.drawing import cylinder_panel
from pidpanel.shell.strains import Layup
from pidpanel.shell.surface_files import read_surface_file
from tests.shells import SANDWICH


def written(path, order, scale=1.0):
    """A cylinder panel of R = 1, 0.8 × 0.6."""
    with gmsh_session():
        parts = cylinder_panel(scale, 0.8 * scale, 0.6 * scale)()
        gmsh.model.occ.synchronize()
        if order:
            gmsh.model.addPhysicalGroup(2, [tag for _, tag in parts["panel"]], name="skin")
            gmsh.option.setNumber("Mesh.MeshSizeMax", 0.2)
            gmsh.model.mesh.generate(2)
            gmsh.model.mesh.setOrder(order)
        gmsh.write(str(path))
    return path


@pytest.mark.parametrize("order", [1, 2, 3, 4])
def test_a_mesh_of_any_order_has_the_area_of_its_surface(tmp_path, order):
    mesh = read_surface_file(written(tmp_path / "a.msh", order), unit=2.0)
    shell = assemble_shell(mesh, {"skin": Layup(SANDWICH)})
    # straight edges of 0.2 m cut off (0.2)²/24 of the arc
    tolerance = {1: 2e-3, 2: 1e-5, 3: 1e-6, 4: 1e-7}[order]
    assert shell.quadrature_weight.sum() == pytest.approx(4 * 0.48, rel=tolerance)
    assert shell.quadrature_normal[:, 2].min() > 0.9


def test_a_step_file_in_millimetres_is_meshed_in_metres(tmp_path):
    mesh = read_surface_file(written(tmp_path / "a.step", 0, 1000.0), 0.2)
    shell = assemble_shell(mesh, {"1": Layup(SANDWICH)})
    assert shell.quadrature_weight.sum() == pytest.approx(0.48, rel=1e-5)


def test_edges_too_short_for_the_surface_are_refused_before_meshing(tmp_path):
    with pytest.raises(ValueError, match="elements; allowed are 50000"):
        read_surface_file(written(tmp_path / "a.step", 0, 1000.0), 1e-4)


@pytest.mark.parametrize(
    ("name", "content", "message"),
    [
        ("a.msh", b"Point(1) = {0, 0, 0};", "does not begin like a gmsh mesh"),
        ("a.step", b"nothing", "does not begin like a STEP file"),
        ("a.msh", b"$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 9 1 9\n$EndNodes\n", "a.msh: "),
        ("a.step", b"ISO-10303-21;\nHEADER;", "a.step: "),
    ],
)
def test_a_damaged_file_is_refused_in_one_line(tmp_path, name, content, message):
    path = tmp_path / name
    path.write_bytes(content)
    with pytest.raises(ValueError, match=message) as error:
        read_surface_file(path, 0.1)
    assert "\n" not in str(error.value)
