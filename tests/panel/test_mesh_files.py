"""Truths of meshes from files: the same panel gives the same frequencies; nothing is misread."""

import resource
import tracemalloc
from dataclasses import replace

import gmsh
import numpy as np
import pytest

from pidpanel.geometry.polygon import Circle, Polygon, Rectangle
from pidpanel.panel import from_study
from pidpanel.panel.flat_mesh import MeshFileError
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.panel.gmsh_files import read_gmsh
from pidpanel.panel.mesh import gmsh_session
from pidpanel.panel.mindlin import assemble_shear_plate
from pidpanel.panel.modes import normal_modes
from pidpanel.panel.nastran import read_nastran
from pidpanel.panel.section import Core, Material, Ply, SandwichSection
from pidpanel.panel.triangles import mesh_triangles
from pidpanel.paths import STUDIES
from pidpanel.study import load_study

FACE = Ply(Material.isotropic(60e9, 0.3, 1600.0), 0.3e-3)
SANDWICH = SandwichSection((FACE,), (FACE,), Core(186e6, 90e6, 32.0, 24.4e-3))
OUTLINE = Polygon(((0.0, 0.0), (1.5, 0.0), (1.5, 1.0), (0.0, 1.0)))
PATCH = Rectangle((0.4, 0.6), (0.4, 0.2))
DECK = """\
$ two quadrilaterals
BEGIN BULK
GRID           1              0.      0.      0.
GRID           2              1.      0.      0.
GRID           3              2.      0.      0.
GRID           4              0.      1.      0.
GRID           5              1.      1.      0.
GRID           6              2.      1.      0.
CQUAD4         1       7       1       2       5       4
CQUAD4         2       8       2       3       6       5
ENDDATA
"""


@pytest.fixture(scope="module")
def original(tmp_path_factory):
    """A mesh of ours, its file, and the frequencies on it."""
    path = tmp_path_factory.mktemp("m") / "original.msh"
    points = {"P": (0.4, 0.6)}
    mesh = mesh_triangles(
        path, OUTLINE, 0.25, {"P1": PATCH}, points, holes={"H": Circle((1.1, 0.5), 0.15, 16)}
    )
    return path, mesh, frequencies(mesh)


def frequencies(mesh):
    return normal_modes(assemble_shear_plate(mesh, SANDWICH), 500.0)[0]


def as_deck(mesh, style):
    """Bulk data of a mesh, in mm, in fixed, long or free fields."""
    lines = [
        "BEGIN BULK",
        "PSHELL         1       1     0.3",
        "MAT1           1  7.+10             0.3",
    ]
    for number, (x, y) in enumerate(1000 * mesh.vertices, 1):
        if style == "long":
            lines.append(f"GRID*   {number:16d}{'':16s}{x:16.10f}{y:16.10f}*")
            lines.append(f"*       {0.0:16.10f}")
        elif style == "free":
            lines.append(f"GRID,{number},,{x:.10f},{y:.10f},0.0")
        else:
            lines.append(f"GRID    {number:8d}{'':8s}{x:8.3f}{y:8.3f}{0.0:8.3f}")
    for number, cell in enumerate(mesh.cells + 1, 1):
        fields = [number, 2 if number - 1 in mesh.patch_cells["P1"] else 1, *cell]
        joined = "," + ",".join(map(str, fields)) if style == "free" else ""
        name = "CTRIA3" if style == "free" else "CTRIA3  "
        lines.append(name + (joined or "".join(f"{field:8d}" for field in fields)))
    return "\n".join([*lines, "ENDDATA", ""])


@pytest.mark.parametrize(("style", "tolerance"), [("long", 1e-7), ("free", 1e-7), ("fixed", 1e-4)])
def test_a_mesh_comes_back_from_nastran_with_its_frequencies(tmp_path, original, style, tolerance):
    _, mesh, expected = original
    path = tmp_path / "panel.bdf"
    path.write_text(as_deck(mesh, style))
    flat = read_nastran(path)
    flat = replace(flat, position=1e-3 * flat.position)
    again = flat.panel_mesh({"group": "2", "shape": PATCH}, {"P": mesh.points["P"]})
    # fixed fields round to a micrometre of elements of centimetres
    np.testing.assert_allclose(frequencies(again), expected, rtol=tolerance)
    np.testing.assert_array_equal(again.patch_cells["group"], mesh.patch_cells["P1"])
    np.testing.assert_array_equal(again.patch_cells["shape"], mesh.patch_cells["P1"])


def test_a_mesh_comes_back_from_gmsh_with_its_frequencies(original):
    path, mesh, expected = original
    again = read_gmsh(path).panel_mesh({"P1": PATCH}, {"P": (0.4, 0.6)})
    np.testing.assert_allclose(frequencies(again), expected, rtol=1e-9)
    assert len(again.patch_cells["P1"]) == len(mesh.patch_cells["P1"])


def test_a_mesh_in_text_may_have_the_line_ends_of_windows(tmp_path):
    places = [(x, y) for y in (0, 400) for x in (0, 400, 800)]
    nodes = "".join(f"{k} {x} {y} 0\n" for k, (x, y) in enumerate(places, 1))
    elements = "1 3 2 1 1 1 2 5 4\n2 3 2 2 2 2 3 6 5\n"
    text = "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n"
    text += f"$Nodes\n6\n{nodes}$EndNodes\n$Elements\n2\n{elements}$EndElements\n"
    meshes = []
    for name, end in (("unix.msh", b"\n"), ("windows.msh", b"\r\n")):
        (tmp_path / name).write_bytes(text.encode().replace(b"\n", end))
        meshes.append(read_gmsh(tmp_path / name))
    np.testing.assert_array_equal(meshes[0].position, meshes[1].position)
    assert len(meshes[1].position) == 6


def test_fields_behind_the_eighth_of_a_line_are_refused_where_they_matter(tmp_path):
    path = tmp_path / "free.blk"
    card = "CQUAD4,1,7,1,2,5,4,0.,0.,{}\n,,,,\n"
    nodes = "".join(f"GRID,{n},,{(n - 1) % 3}.,{(n - 1) // 3}.,0.\n" for n in range(1, 7))
    for mark in ("", "+A1", "ABC"):
        path.write_text(nodes + "SPC1,1,123,1,2,3,4,5,6,7,8,9,10\n" + card.format(mark))
        assert len(read_nastran(path, ["SPC1"]).triangles) == 2
    path.write_text(nodes + card.format("1.,2."))
    with pytest.raises(MeshFileError, match=r"free.blk:7: CQUAD4: '1., 2.' follows the eighth"):
        read_nastran(path)
    path.write_text("** abaqus\n*NODE\n1, 0., 0.\n")
    with pytest.raises(ValueError, match="begins like an input of Abaqus"):
        read_nastran(path)


def test_a_group_of_gmsh_has_a_name_and_a_number(tmp_path):
    path = tmp_path / "panel.msh"
    mesh_triangles(path, OUTLINE, 0.25, {"P1": PATCH}, {})
    flat = read_gmsh(path)
    number = next(number for number, name in flat.numbers.items() if name == "P1")
    mesh = flat.panel_mesh({"name": "P1", "number": number}, {})
    np.testing.assert_array_equal(mesh.patch_cells["name"], mesh.patch_cells["number"])


def test_quadrilaterals_become_two_triangles_each_in_their_group(tmp_path):
    path = tmp_path / "two.bdf"
    path.write_text(DECK)
    flat = read_nastran(path)
    assert flat.triangles.shape == (4, 3)
    assert {name: cells.tolist() for name, cells in flat.groups.items()} == {
        "7": [0, 1],
        "8": [2, 3],
    }
    assert flat.at_node(6) == (2.0, 1.0)
    turned = DECK.replace("1       2       5       4", "4       5       2       1")
    path.write_text(turned.replace("2       3       6       5", "5       6       3       2"))
    np.testing.assert_allclose(areas(read_nastran(path)), 0.5)


def areas(flat):
    x, y = flat.position[flat.triangles].transpose(2, 1, 0)
    return 0.5 * ((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]))


def test_exponents_without_their_e_are_read(tmp_path):
    path = tmp_path / "two.bdf"
    deck = DECK.replace("      2.      0.      0.", "    2.+0   0.0-3      0.")
    path.write_text(deck.replace("      2.      1.", "    2.D0    1.E0"))
    assert read_nastran(path).at_node(3) == (2.0, 0.0)
    assert read_nastran(path).at_node(6) == (2.0, 1.0)


def test_a_deck_of_an_analysis_is_read_without_what_the_study_states(tmp_path):
    control = "SOL 103\nCEND\nSPC = 1\nMETHOD = 10\nBEGIN BULK\nPARAM,POST,-1\nEIGRL,10,,2000."
    bulk = [
        "PCOMP,7,,,,,,,", "+,1,0.25,0.,YES,2,20.,0.,YES,", "+,1,0.25,0.,YES",
        "MAT8,2,1.,1.,.3,1.,186.,90.,3.2-11", "SPC1,1,123456,1,3", "GRID,77,,1.,0.5,-30.",
        "CONM2,9,77,,2.5", "RBE2,10,77,123456,2,5", "ENDDATA",
    ]  # fmt: skip
    path = tmp_path / "deck.bdf"
    path.write_text(DECK.replace("BEGIN BULK", control).replace("ENDDATA", "\n".join(bulk)))
    with pytest.raises(ValueError) as caught:
        read_nastran(path)
    assert [line.split()[2] for line in str(caught.value).splitlines()] == ["SPC1", "CONM2", "RBE2"]
    assert "list their cards in panel.mesh.ignore" in str(caught.value)
    whole = read_nastran(path, ("SPC1", "CONM2", "RBE2"))
    plain = tmp_path / "plain.bdf"
    plain.write_text(DECK)
    for name in ("node", "position", "triangles"):
        np.testing.assert_array_equal(getattr(whole, name), getattr(read_nastran(plain), name))
    assert whole.remarks == (
        "1 SPC1", "1 CONM2 (mass 2.5 in the unit of the deck)", "1 RBE2",
        "1 node without an element (77)",
    )  # fmt: skip


def test_a_refined_mesh_has_the_nodes_area_and_groups_of_its_file(tmp_path):
    path = tmp_path / "two.bdf"
    path.write_text(DECK.replace("2.      1.", "2.     1.5"))
    flat = read_nastran(path)
    fine = flat.refined()
    assert fine.triangles.shape == (16, 3) and len(fine.node) == len(set(fine.node.tolist())) == 15
    assert [fine.at_node(number) for number in flat.node] == [tuple(p) for p in flat.position]
    assert (areas(fine) > 0).all()
    for group in "78":
        whole = areas(flat)[flat.groups[group]].sum()
        assert areas(fine)[fine.groups[group]].sum() == pytest.approx(whole, rel=1e-14)
    # of four equal parts
    np.testing.assert_allclose(areas(fine), np.repeat(areas(flat) / 4, 4), rtol=1e-14)


def test_a_mesh_is_not_refined_beyond_what_memory_holds(tmp_path, monkeypatch):
    study = load_study(STUDIES / "bdf_panel.yaml")
    panel, whole = (
        StudiedPanel(study.panel.model_copy(update={"mesh": mesh}))
        for mesh in (study.panel.mesh.model_copy(update={"refine": times}) for times in (4, 0))
    )
    coarse = len(whole.foreign.triangles)
    assert len(panel.foreign.triangles) == 256 * coarse
    monkeypatch.setattr(from_study, "MOST_ELEMENTS", 256 * coarse - 1)
    with pytest.raises(ValueError, match=r"with mesh\.refine = 4; allowed are"):
        _ = StudiedPanel(panel.panel).foreign


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("BEGIN BULK", "INCLUDE 'more.bdf'", "deck.bdf:2: 'more.bdf' is not a file in"),
        ("BEGIN BULK", "INCLUDE 'more.bdf'\nBEGIN BULK", "deck.bdf:2: 'more.bdf' is not a file in"),
        ("BEGIN BULK", "SOL 103", "deck.bdf:2: card SOL is not read; allowed are GRID"),
        ("ENDDATA", "SPC1           1     123       1", "deck.bdf:11: card SPC1 is not read"),
        ("ENDDATA", "CSHEAR         3       7       1       2       5       4", "deck.bdf:11: card CSHEAR is not read"),
        ("ENDDATA", "CBAR           3       7       1       2", "deck.bdf:11: card CBAR is not read"),
        ("GRID           2        ", "GRID           2       5", "deck.bdf: coordinate system 5 must be a CORD1R"),
        ("GRID           2              1.      0.      0.", "GRID           2              1.      0.      0.               x", "deck.bdf:4: GRID: PS = x is not a number"),
        ("1       2       5       4", "1       2       5       4    45.x", "deck.bdf:9: CQUAD4: 45.x is not a number"),
        ("BEGIN BULK", "BEGIN BULK\nGRDSET,,5", "deck.bdf: coordinate system 5 must be a CORD1R"),
        ("ENDDATA", "BEGIN SUPER=1", "deck.bdf:11: card BEGIN is not read"),
        ("GRID           3              2.", "=\nGRID           3              2.", "deck.bdf:5: card = is not read"),
        ("2.      0.      0.", "2.      0.      x", "deck.bdf:5: GRID: x is not a number"),
        ("GRID           3", "GRID           a", "deck.bdf:5: GRID: a is not allowed; a number from 1 is needed"),
        ("GRID           3", "GRID           2", "node 2 appears twice"),
        ("CQUAD4         2", "CQUAD4         1", "element 1 appears twice"),
        ("2       3       6       5", "2       3       9       5", "element 2: node 9 is missing"),
        ("2       3       6       5", "2       3       3       5", "element 2: a node appears twice in it"),
        ("2       3       6       5", "2       6       3       5", "element 2: its corners do not form"),
        ("      2.      0.      0.", "     nan      0.      0.", "GRID: nan is not a number"),
        ("2.      0.      0.", "2.      0.      1.", "node 3 is 0.524648 m off the plane of most others"),
        ("CQUAD4         2       8       2", "GRID           7              1.      0.      0.\nCQUAD4         2       8       7", "nodes 2 and 7 are at one place (1, 0) m: the panel is cracked"),
    ],
)  # fmt: skip
def test_a_deck_that_would_be_misread_is_refused_in_one_line(tmp_path, old, new, message):
    assert DECK.count(old) >= 1
    path = tmp_path / "deck.bdf"
    path.write_text(DECK.replace(old, new, 1))
    with pytest.raises(ValueError) as caught:
        read_nastran(path)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value) and "deck.bdf" in str(caught.value)


def test_a_triangle_without_area_is_refused(tmp_path):
    path = tmp_path / "deck.bdf"
    path.write_text(DECK.replace("ENDDATA", "CTRIA3         3       7       1       2       3"))
    with pytest.raises(ValueError, match="element 3 is degenerate: it has no area"):
        read_nastran(path)


def test_elements_of_second_order_are_refused_in_gmsh_files(tmp_path):
    path = tmp_path / "second.msh"
    with gmsh_session():
        gmsh.model.occ.addRectangle(0, 0, 0, 1, 1)
        gmsh.model.occ.synchronize()
        gmsh.model.mesh.generate(2)
        gmsh.model.mesh.setOrder(2)
        gmsh.write(str(path))
    with pytest.raises(
        ValueError, match="is a Triangle 6; allowed are triangles and quadrilaterals"
    ):
        read_gmsh(path)
    (tmp_path / "none.msh").write_text("no mesh")
    with pytest.raises(ValueError, match=r"none.msh: (not a gmsh mesh|no triangles)"):
        read_gmsh(tmp_path / "none.msh")


def test_places_that_a_foreign_mesh_does_not_have_are_refused(tmp_path):
    path = tmp_path / "two.bdf"
    path.write_text(DECK)
    flat = read_nastran(path)
    for patches, points, message in (
        ({"P": "9"}, {}, "has no group 9; it has 7, 8"),
        ({"P": Rectangle((1.0, 0.5), (0.5, 0.5))}, {}, "cover 0 m² of its 0.25 m²"),
        ({}, {"A": (0.1, 0.0)}, r"point 'A' = \(0.1, 0\) m: no node is there; the nearest is 1"),
    ):
        with pytest.raises(ValueError, match=message):
            flat.panel_mesh(patches, {}, points)
    with pytest.raises(ValueError, match="no node 17; it has 6 nodes from 1 to 6"):
        flat.at_node(17)


MESH = """\
$MeshFormat
4.1 0 8
$EndMeshFormat
$Nodes
1 4 1 4
2 1 0 4
1
2
3
4
0 0 0
1 0 0
1 1 0
0 1 0
$EndNodes
$Elements
1 1 1 1
2 1 3 1
1 1 2 3 4
$EndElements
"""


def test_gmsh_executes_nothing_for_a_mesh(tmp_path):
    trace = tmp_path / "trace"
    command = f'SystemCall "touch {trace}";\n'
    path = tmp_path / "panel.msh"
    for text in (f"\n$MeshFormat;\n{command}", f"$MeshFormat;\n{command}", f"$Comments\n{command}"):
        path.write_text(text)
        with pytest.raises(ValueError, match=r"panel.msh: not a gmsh mesh: it has no \$MeshFormat"):
            read_gmsh(path)
    (tmp_path / "panel.msh.opt").write_text(command)
    path.write_text(MESH + command + "$NodeData\n1\n")
    assert read_gmsh(path).triangles.shape == (2, 3)
    assert not trace.exists()


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("1 4 1 4\n", "1 1000000000 1 4\n", ":5: states 1000000000 nodes; a file of"),
        ("1 1 1 1\n", "1 1000000000 1 1\n", ":17: states 1000000000 elements; a file of"),
        ("2 1 0 4\n", "2 1 0 1000000000\n", ": not a gmsh mesh: it states more nodes or elements"),
        ("$EndNodes", "$InterpolationScheme\n$EndNodes", ": section $InterpolationScheme begins inside"),
    ],
)  # fmt: skip
def test_a_mesh_that_states_more_than_it_has_is_refused(tmp_path, old, new, message):
    path = tmp_path / "panel.msh"
    path.write_text(MESH.replace(old, new, 1))
    before = peak_memory()
    with pytest.raises(ValueError) as caught:
        read_gmsh(path)
    assert f"{path}{message}" in str(caught.value) and "\n" not in str(caught.value)
    assert peak_memory() - before < 200e6


def peak_memory():
    """Most memory that this process has had [bytes]."""
    return 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss


def test_a_file_larger_than_any_mesh_is_not_read(tmp_path):
    for name, read in (("panel.msh", read_gmsh), ("panel.bdf", read_nastran)):
        with (tmp_path / name).open("wb") as file:
            file.truncate(10**12)
        with pytest.raises(ValueError, match=f"{name}: has 1e\\+06 MB; allowed are 100 MB"):
            read(tmp_path / name)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("INCLUDE '/etc/hostname'\n", "deck.bdf:1: '/etc/hostname' is not a file in"),
        ("INCLUDE 'deck.bdf'\n", "deck.bdf:1: 'deck.bdf' is not a file in"),
        ("INCLUDE '/etc/\n        hostname'\n", "deck.bdf:1: '/etc/hostname' is not a file in"),
        ("GRID,9,,0.,0.,0.\n" + 50000 * "+\n", "deck.bdf:10: a card has more than 64 fields"),
        ("".join(f"X{k}\n" for k in range(50000)), "deck.bdf: 981 further mistakes"),
    ],
)
def test_a_deck_reads_no_other_file_and_is_not_read_for_ever(tmp_path, text, message):
    path = tmp_path / "deck.bdf"
    path.write_text(text + DECK.replace("BEGIN BULK\n", ""))
    tracemalloc.start()
    try:
        with pytest.raises(ValueError) as caught:
            read_nastran(path)
        assert tracemalloc.get_traced_memory()[1] < 100 * path.stat().st_size + 1e6
    finally:
        tracemalloc.stop()
    assert message in str(caught.value)
