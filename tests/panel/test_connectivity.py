"""Truths of what a mesh file covers: each place once, joined along whole edges; else it is refused.

All decks are of one plate, 0.4 m × 0.3 m in elements of 0.1 m.
"""

import gmsh
import numpy as np
import pytest

from pidpanel.panel.gmsh_files import read_gmsh
from pidpanel.panel.mesh import gmsh_session
from pidpanel.panel.nastran import read_nastran

NODES = {1 + i + 5 * j: (0.1 * i, 0.1 * j) for j in range(4) for i in range(5)}
QUADS = {
    1 + i + 4 * j: [1 + i + 5 * j, 2 + i + 5 * j, 7 + i + 5 * j, 6 + i + 5 * j]
    for j in range(3) for i in range(4)
}  # fmt: skip
AREA = 0.12


def deck(path, nodes, elements, more=()):
    lines = [f"GRID,{number},,{x:.9f},{y:.9f},0." for number, (x, y) in nodes.items()]
    for number, corners in elements.items():
        name = "CTRIA3" if len(corners) == 3 else "CQUAD4"
        lines.append(f"{name},{number},{1 + (number > 6)},{','.join(map(str, corners))}")
    path.write_text("\n".join([*lines, *more, "ENDDATA", ""]))
    return path


def area(flat):
    x, y = flat.position[flat.triangles].transpose(2, 1, 0)
    return 0.5 * np.sum((x[1] - x[0]) * (y[2] - y[0]) - (x[2] - x[0]) * (y[1] - y[0]))


def slit(gap, first=7, last=8):
    """Nodes and elements with own nodes for the elements above a part of the row y = 0.1 m."""
    own = {number: number + 700 for number in range(first, last + 1)}
    nodes = NODES | {new: (NODES[old][0], NODES[old][1] + gap) for old, new in own.items()}
    above = {k: [own.get(n, n) for n in q] if 4 < k <= 8 else q for k, q in QUADS.items()}
    return nodes, above


def changed(**elements):
    return NODES, QUADS | {int(key[1:]): corners for key, corners in elements.items()}


MOVED = {number: (x + 0.05, y + 0.05) for number, (x, y) in NODES.items()}
HALVES = {1: [1, 2, 7, 21], 13: [21, 7, 6]}
REFUSED = {
    "every element twice": (NODES, QUADS | {n + 1000: q for n, q in QUADS.items()}, "elements 1 and 1001 overlap at"),
    "a doubler": (NODES, QUADS | {1006: QUADS[6]}, "elements 6 and 1006 overlap at"),
    "a doubler the other way round": (NODES, QUADS | {1006: QUADS[6][::-1]}, "elements 6 and 1006 overlap at"),
    "a triangle over a quadrilateral": (*changed(e99=[7, 8, 13]), "elements 6 and 99 overlap"),
    "a triangle outside the diagonal": (*changed(e99=[7, 8, 12]), "elements 6 and 99 overlap"),
    "a triangle over two elements": (*changed(e99=[7, 9, 12]), "node 8 at (0.1, 0.1) m|node 8 at (0.2, 0.1) m|overlap"),
    "a hanging node": (NODES | {21: (0.0, 0.04)}, QUADS | HALVES | {1: [1, 2, 7, 6], 13: [6, 7, 21]}, "overlap"),
    "a T-junction": (NODES | {21: (0.15, 0.1)}, QUADS | {2: [2, 3, 8, 21], 13: [2, 21, 7]}, "node 21 at (0.15, 0.1) m is on the edge between nodes 7 and 8"),
    "a second plate that overlaps": (NODES | {n + 100: p for n, p in MOVED.items()}, QUADS | {k + 100: [n + 100 for n in q] for k, q in QUADS.items()}, "pieces"),
    "a second plate that was not merged": (NODES | {n + 100: (x + 0.4, y) for n, (x, y) in NODES.items()}, QUADS | {k + 100: [n + 100 for n in q] for k, q in QUADS.items()}, "nodes 5 and 101 are at one place (0.4, 0) m"),
    **{f"a slit of {gap:g}": (*slit(gap), "nodes 7 and 707 are ") for gap in (0.0, 1e-8, 1e-6, 1e-5, 1e-4)},
    "a slit with one double node": (*slit(1e-6, 8, 8), "nodes 8 and 708 are 1e-06 m apart at (0.2, 0.1"),
    "nodes crossed by a micrometre": (*slit(-1e-6), "crosses itself at|touches itself at"),
    "a fold": (NODES | {20: (0.22, 0.12)}, QUADS, "convex|overlap|crosses itself"),
}  # fmt: skip


@pytest.mark.parametrize("case", REFUSED)
def test_elements_that_overlap_or_do_not_join_are_refused_with_their_place(tmp_path, case):
    nodes, elements, message = REFUSED[case]
    path = deck(tmp_path / "panel.bdf", nodes, elements)
    with pytest.raises(ValueError) as caught:
        read_nastran(path)
    assert any(part in str(caught.value) for part in message.split("|")), str(caught.value)
    assert "\n" not in str(caught.value) and str(path) in str(caught.value)


ACCEPTED = {
    "numbers in another order": ({1000 - 7 * n: p for n, p in NODES.items()}, {90 - k: [1000 - 7 * n for n in q] for k, q in QUADS.items()}, ""),
    "triangles and quadrilaterals": (*changed(e6=[7, 8, 13], e13=[7, 13, 12]), ""),
    "elements upside down": (*changed(e6=QUADS[6][::-1], e7=QUADS[7][::-1]), "2 elements upside down"),
    "all elements upside down": (NODES, {k: q[::-1] for k, q in QUADS.items()}, ""),
    "nodes that no element uses": (NODES | {999: (9.0, 9.0)}, QUADS, "1 node without an element (999)"),
    "a triangle with two close nodes": (NODES | {99: (0.05, 0.3), 98: (0.05005, 0.3)}, {k: q for k, q in QUADS.items() if k != 9} | {9: [11, 99, 16], 13: [11, 98, 99], 14: [11, 12, 98], 15: [12, 17, 98]}, "1 triangle with nodes closer than 0.001"),
}  # fmt: skip


@pytest.mark.parametrize("case", ACCEPTED)
def test_meshes_of_the_same_plate_have_its_area_and_state_what_is_unusual(tmp_path, case):
    nodes, elements, remark = ACCEPTED[case]
    flat = read_nastran(deck(tmp_path / "panel.bdf", nodes, elements))
    assert area(flat) == pytest.approx(AREA, rel=1e-12)
    assert (flat.remarks == ()) if not remark else (remark in flat.remarks[0])


def test_what_a_deck_has_beyond_the_mesh_is_counted_with_its_mass(tmp_path):
    more = [
        "CONM2,90,1,,0.5", "CONM2,91,2,,0.25", "CORD2R,1,,0.,0.,0.,0.,0.,1.", "+,1.,0.,0.",
        "SPC1,1,123,1", *["+,2,3,4,5,6,7,8,9"] * 20, "END BULK",
    ]  # fmt: skip
    path = deck(tmp_path / "panel.bdf", NODES, QUADS, more)
    text = path.read_text().replace("CQUAD4,6,1,7,8,13,12", "CQUADR,6,1,7,8,13,12,45.,0.01")
    path.write_text(text.replace("GRID,1,,0.000000000,0.000000000,0.", "GRID,1,,0.,0.,0.,1,126"))
    flat = read_nastran(path, ("CONM2", "SPC1"))
    assert area(flat) == pytest.approx(AREA, rel=1e-12)
    assert set(flat.remarks) == {
        "1 GRID with PS", "1 element with THETA or MCID: the section of the study counts",
        "1 element with ZOFFS: the section of the study counts", "2 CONM2 (mass 0.75 in the unit of the deck)", "1 SPC1",
    }  # fmt: skip


@pytest.mark.parametrize("card", ["GRIDG,9,1,,,", "CTRIAX6,9,1,1,2,7,6", "CHEXA,9,1"])
def test_a_card_that_places_nodes_or_elements_cannot_be_ignored(tmp_path, card):
    path = deck(tmp_path / "panel.bdf", NODES, QUADS, [card])
    with pytest.raises(ValueError, match="is not read"):
        read_nastran(path, (card.partition(",")[0],))


@pytest.fixture(scope="module")
def two_groups(tmp_path_factory):
    """The same plate with a patch that is in two groups, by format of its file."""
    folder = tmp_path_factory.mktemp("groups")
    paths = {}
    with gmsh_session():
        occ = gmsh.model.occ
        plate, patch = occ.addRectangle(0, 0, 0, 0.4, 0.3), occ.addRectangle(0.1, 0.1, 0, 0.1, 0.1)
        occ.fragment([(2, plate)], [(2, patch)])
        occ.synchronize()
        faces = [tag for _, tag in gmsh.model.getEntities(2)]
        gmsh.model.addPhysicalGroup(2, faces, name="panel")
        gmsh.model.addPhysicalGroup(2, [patch], name="patch")
        gmsh.option.setNumber("Mesh.MeshSizeMax", 0.05)
        gmsh.model.mesh.generate(2)
        for version in (2.2, 4.1):
            for binary in (0, 1):
                gmsh.option.setNumber("Mesh.MshFileVersion", version)
                gmsh.option.setNumber("Mesh.Binary", binary)
                paths[version, binary] = folder / f"{version}_{binary}.msh"
                gmsh.write(str(paths[version, binary]))
    return paths


@pytest.mark.parametrize("version", [2.2, 4.1])
@pytest.mark.parametrize("binary", [0, 1])
def test_an_element_in_two_groups_is_one_element_in_both(two_groups, version, binary):
    flat = read_gmsh(two_groups[version, binary])
    assert area(flat) == pytest.approx(AREA, rel=1e-12)
    mesh = flat.panel_mesh({"all": "panel", "P": "patch"}, {})
    corners = mesh.vertices[mesh.cells[mesh.patch_cells["P"]]]
    assert len(mesh.patch_cells["all"]) == len(mesh.cells)
    assert corners.reshape(-1, 2).min(axis=0) == pytest.approx([0.1, 0.1])
    assert corners.reshape(-1, 2).max(axis=0) == pytest.approx([0.2, 0.2])


OLD = """\
$MeshFormat
2.2 0 8
$EndMeshFormat
$PhysicalNames
2
2 1 "left"
2 2 "right"
$EndPhysicalNames
$Nodes
6
1 0 0 0
2 1 0 0
3 2 0 0
4 0 1 0
5 1 1 0
6 2 1 0
$EndNodes
$Elements
2
1 3 2 1 1 1 2 5 4
2 3 2 2 1 2 3 6 5
$EndElements
"""


def test_groups_of_format_2_are_those_of_the_elements(tmp_path):
    path = tmp_path / "panel.msh"
    path.write_text(OLD)
    groups = read_gmsh(path).groups
    assert {name: cells.tolist() for name, cells in groups.items()} == {
        "left": [0, 1],
        "right": [2, 3],
    }


@pytest.mark.parametrize(
    ("old", "new", "message"),
    [
        ("2 3 2 2 1 2 3 6 5", "1 3 2 2 1 2 3 6 5", "element 1 appears twice"),
        ("2\n1 3 2 1", "3\n3 3 2 1 1 1 2 5 4\n1 3 2 1", "elements 1 and 3 overlap at"),
        ("6\n1 0 0 0", "7\n6 9 9 9\n1 0 0 0", "node 6 appears twice"),
        ("6 2 1 0", "6 2 1 0.1", "the panel must be plane"),
    ],
)
def test_what_gmsh_would_drop_from_format_2_is_refused(tmp_path, old, new, message):
    path = tmp_path / "panel.msh"
    path.write_text(OLD.replace(old, new, 1))
    with pytest.raises(ValueError, match=message) as caught:
        read_gmsh(path)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize("number", [2**63, 2**64 - 2])
def test_a_node_number_beyond_64_bits_is_refused(tmp_path, number):
    path = tmp_path / "panel.msh"
    text = """$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 3 1 {0}\n2 1 0 3\n1\n2\n{0}
0 0 0\n1 0 0\n1 1 0\n$EndNodes\n$Elements\n1 1 1 1\n2 1 2 1\n1 1 2 {0}\n$EndElements\n"""
    path.write_text(text.format(number))
    with pytest.raises(ValueError, match=r"panel\.msh: ") as caught:
        read_gmsh(path)
    assert "\n" not in str(caught.value)


NEW = """$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 6 1 6\n2 1 0 6\n1\n2\n3\n4\n5\n6
0 0 0\n1 0 0\n2 0 0\n0 1 0\n1 1 0\n2 1 0\n$EndNodes\n$Elements\n1 2 1 2\n2 1 3 2\n1 1 2 5 4
2 2 3 6 5\n$EndElements\n"""


@pytest.mark.parametrize(
    ("text", "old", "new", "message"),
    [
        (NEW, "1 6 1 6", "1 3 1 6", "not a gmsh mesh|is missing"),
        (NEW, "1 2 1 2\n", "1 1 1 2\n", "not a gmsh mesh|states 1 elements"),
        (NEW, "1 2 1 2\n2 1 3 2", "1 2 1 2\n2 1 3 1", "states 2 elements and has 1"),
        (
            OLD,
            "6\n1 0 0 0",
            "5\n1 0 0 0",
            "not a gmsh mesh|is missing",
        ),  # gmsh reads what memory holds
        (OLD, "2 3 2 2 1 2 3 6 5", "2 16 2 2 1 2 3 6 5 1 2 3 4", "1 of them in first order"),
    ],
)
def test_a_gmsh_file_that_contradicts_itself_is_refused_in_one_line(
    tmp_path, text, old, new, message
):
    path = tmp_path / "panel.msh"
    assert old in text
    path.write_text(text)
    assert len(read_gmsh(path).triangles) == 4
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(ValueError, match=message) as caught:
        read_gmsh(path)
    assert str(path) in str(caught.value) and "\n" not in str(caught.value)
