"""Decks by the rules of bulk data: the same plate in any style, frame and plane."""

import numpy as np
import pytest
import scipy.linalg

from pidpanel.nastran import read_deck
from pidpanel.nastran.cards import numbers_of
from pidpanel.panel.modes import first_modes
from pidpanel.panel.nastran import read_nastran
from pidpanel.panel.section import ThinSection
from pidpanel.panel.supports import Supports
from pidpanel.panel.thin import assemble_thin_plate

A, B, NX, NY = 1.2, 0.8, 30, 20  # edges [m], elements
D, MASS = 1000.0, 4.0  # bending stiffness [N m], mass per area [kg/m²]
TURN = scipy.linalg.expm(np.cross(np.eye(3), [0.4, -0.9, 0.3]))
SHIFT = np.array([0.1, 0.2, 0.3])
ORIGIN = np.array([2.0, -1.0, 0.5])


def places():
    x, y = np.meshgrid(np.linspace(0, A, NX + 1), np.linspace(0, B, NY + 1))
    return np.stack([x.ravel(), y.ravel(), 0 * x.ravel()], axis=1)


def elements():
    k = np.arange((NX + 1) * (NY + 1)).reshape(NY + 1, NX + 1) + 1
    return np.stack([k[:-1, :-1], k[:-1, 1:], k[1:, 1:], k[1:, :-1]], axis=-1).reshape(-1, 4)


def number(value, width):
    return next(t for t in (f"{value:.{d}g}" for d in range(15, 0, -1)) if len(t) <= width)


def small(name, *fields):
    text = name.ljust(8)
    for k, field in enumerate(fields):
        if k and k % 8 == 0:
            text += "\n" + 8 * " "
        text += (number(field, 8) if isinstance(field, float) else str(field)).ljust(8)
    return text


def large(name, *fields):
    rows = [fields[k : k + 4] for k in range(0, len(fields), 4)]
    lines = [
        ("" if k else f"{name}*").ljust(8) * (k == 0)
        + ("*".ljust(8) if k else "")
        + "".join((f"{f:.12g}" if isinstance(f, float) else str(f)).ljust(16) for f in row)
        for k, row in enumerate(rows)
    ]
    return "\n".join(lines)


def free(name, *fields, mark=",+\n+"):
    texts = [f"{f:.14g}" if isinstance(f, float) else str(f) for f in fields]
    return mark.join(
        (f"{name}," if not k else ",") + ",".join(texts[k : k + 8]) for k in range(0, len(texts), 8)
    )


def tabbed(name, *fields):
    return "\t".join([name, *(number(f, 7) if isinstance(f, float) else str(f) for f in fields)])


STYLES = {
    "small": small,
    "large": large,
    "free": free,
    "free, continued by a comma": lambda *card: free(*card, mark=",\n"),
    "lower case": lambda *card: free(*card).lower(),
    "tabs": tabbed,
    "comments": lambda *card: "$ GRID,99\n" + free(*card, mark=",+A1\n+A1").replace("\n", " $,,\n"),
}


def deck(x, style=free, cards=(), head="SOL 103\nCEND\nBEGIN BULK\n", options=(), end="ENDDATA\n"):
    nodes = [style("GRID", k, *(options or ("",)), *map(float, p)) for k, p in enumerate(x, 1)]
    quads = [style("CQUAD4", k, 7 + k % 2, *q) for k, q in enumerate(elements().tolist(), 1)]
    return head + "\n".join([*nodes, *quads, *cards]) + "\n" + end


def frequencies(flat):
    mesh = flat.panel_mesh({}, {})
    plate = assemble_thin_plate(mesh, ThinSection(D, MASS), Supports("simply_supported"))
    return first_modes(plate, 4)[1]


@pytest.fixture(scope="module")
def flat(tmp_path_factory):
    path = tmp_path_factory.mktemp("flat") / "flat.bdf"
    path.write_text(deck(places()))
    return frequencies(read_nastran(path))


CLOSED = sorted(
    np.pi / 2 * np.sqrt(D / MASS) * ((m / A) ** 2 + (n / B) ** 2)
    for m, n in [(1, 1), (2, 1), (1, 2), (3, 1)]
)


def test_a_panel_in_any_plane_has_the_frequencies_of_the_closed_form_and_of_the_flat_one(
    tmp_path, flat
):
    path = tmp_path / "tilted.bdf"
    path.write_text(deck(ORIGIN + places() @ TURN.T))
    tilted = read_nastran(path)
    np.testing.assert_allclose(flat, CLOSED, rtol=1e-3)
    np.testing.assert_allclose(frequencies(tilted), flat, rtol=1e-6)
    assert tilted.remarks[0].startswith("a plane")
    np.testing.assert_allclose(np.ptp(tilted.position @ tilted.axes.T, axis=0), np.ptp(places() @ TURN.T, axis=0), atol=1e-9)  # fmt: skip


@pytest.mark.parametrize("style", STYLES)
def test_a_deck_in_any_style_is_the_same_plate(tmp_path, flat, style):
    path = tmp_path / "plate.bdf"
    head = "" if style == "tabs" else "SOL 103\nCEND\nbegin bulk\n"
    path.write_text(deck(places(), STYLES[style], head=head))
    mesh = read_nastran(path)
    assert {name: len(cells) for name, cells in mesh.groups.items()} == {"7": 600, "8": 600}
    np.testing.assert_allclose(frequencies(mesh), flat, rtol=2e-6)


@pytest.mark.parametrize("kind", ["CORD2R", "CORD2C", "CORD2S", "CORD1R"])
def test_nodes_in_a_system_of_their_own_are_where_it_says(tmp_path, flat, kind):
    # Three points of the system: its origin, on its z axis, in its plane of x and z
    points = ORIGIN + np.array([[0, 0, 0], TURN[:, 2], TURN[:, 0] + 3 * TURN[:, 2]])
    x, y, z = (places() + SHIFT).T
    angle, radius = np.degrees(np.arctan2(y, x)), np.hypot(x, y)
    local = {
        "R": [x, y, z],
        "C": [radius, angle, z],
        "S": [np.hypot(radius, z), np.degrees(np.arctan2(radius, z)), angle],
    }[kind[-1]]
    cards = [free(kind, 5, 0, *points.ravel().tolist())]
    if kind == "CORD1R":
        cards = [free("GRID", 9000 + k, 0, *p) for k, p in enumerate(points.tolist())]
        cards += [free(kind, 4, 9001, 9000, 9002, 5, 9000, 9001, 9002)]
    path = tmp_path / "plate.bdf"
    path.write_text(deck(np.transpose(local), cards=["GRDSET,,5", *cards]))
    read = read_deck(path)
    expected = ORIGIN + (places() + SHIFT) @ TURN.T
    np.testing.assert_allclose(read.position[: len(expected)], expected, atol=1e-12)
    np.testing.assert_allclose(frequencies(read_nastran(path)), flat, rtol=1e-6)


def test_a_panel_is_chosen_out_of_a_spacecraft_by_property_or_set(tmp_path, flat):
    x = np.vstack([places(), [[0, 0, 1], [A, 0, 1], [3.0, 3.0, 3.0]]])  # a wall and a far node
    n = len(places())
    cards = [
        free("CQUAD4", 5000, 9, 1, NX + 1, n + 2, n + 1),
        free("CHEXA", 5001, 9, *range(1, 9)),
        free("RBE2", 5002, n + 3, 123456, 1, 2, 3),
        free("SPC1", 1, 123456, n + 3),
        free("CONM2", 5003, n + 3, 0, 12.0),
    ]
    head = "SOL 103\nCEND\nSET 4 = 1 THRU 600\nBEGIN BULK\n"
    path = tmp_path / "craft.bdf"
    path.write_text(deck(x, cards=cards, head=head))
    for groups in (["7", "8"], ["SET 4"]):
        mesh = read_nastran(path, groups=groups)
        np.testing.assert_allclose(frequencies(mesh), flat, rtol=1e-12)
        assert mesh.remarks == (
            "1 CHEXA, 1 RBE2, 1 SPC1, 1 CONM2 (mass 12 in the unit of the deck)",
        )
    with pytest.raises(ValueError, match="no group 12; it has 8, 7, 9, SET 4"):
        read_nastran(path, groups=["12"])
    with pytest.raises(ValueError, match="card CHEXA is not read"):
        read_nastran(path)


def test_elements_of_second_order_count_by_their_corners(tmp_path):
    x = [[0, 0], [2, 0], [2, 2], [0, 2], [1, 0], [2, 1], [1, 2], [0, 1], [4, 0], [3, 0], [3, 1.2]]
    nodes = [free("GRID", k, "", *map(float, p), 0.0) for k, p in enumerate(x, 1)]
    cards = [
        free("CQUAD8", 1, 7, *range(1, 9), "", "", "", "", 30.0, 0.1),
        free("CTRIA6", 2, 7, 2, 9, 3, 10, 11, 6),
    ]
    path = tmp_path / "two.bdf"
    path.write_text("\n".join([*nodes, *cards, ""]))
    mesh = read_nastran(path)
    assert len(mesh.triangles) == 3 and sorted(mesh.node) == [1, 2, 3, 4, 9]
    assert mesh.remarks == (
        "1 element with THETA or MCID: the section of the study counts",
        "1 element with ZOFFS: the section of the study counts",
        "1 element with curved edges, which are straight here",
    )


def test_a_node_off_the_plane_by_more_than_the_tolerance_is_named(tmp_path):
    path = tmp_path / "plate.bdf"
    extent = np.ptp(places() @ TURN.T, axis=0).max()
    for share, is_flat in ((0.8e-4, True), (1.3e-4, False)):
        x = places()
        x[300, 2] += share * extent
        path.write_text(deck(ORIGIN + x @ TURN.T))
        if is_flat:
            assert len(read_nastran(path).node) == len(x)
        else:
            with pytest.raises(ValueError, match=r"node 301 is \S+ m off the plane"):
                read_nastran(path)


def test_constraints_are_those_that_the_case_control_chooses(tmp_path):
    cards = [
        "SPCADD,40,1,2", "SPC1,1,3,1,THRU,9,EXCEPT,4,5", "SPC,2,20,123,0.,21,3", "SPC1,3,3,30",
        "GRID,9000,,0.,0.,3.,,3",
    ]  # fmt: skip
    path = tmp_path / "plate.bdf"

    def held(control):
        path.write_text(deck(places(), cards=cards, head=f"SOL 103\nCEND\n{control}BEGIN BULK\n"))
        return read_deck(path).constraints()

    chosen, remarks = held("SPC = 40\n")
    assert remarks == []
    assert chosen == dict.fromkeys([1, 2, 3, 6, 7, 8, 9, 21, 9000], "3") | {20: "123"}
    assert set(held("SUBCASE 1\n  SPC = 3\nSUBCASE 2\n SPC=2\n")[0]) == {30, 9000}
    assert "first subcase" in held("SUBCASE 1\n  SPC = 3\nSUBCASE 2\n SPC=2\n")[1][0]
    assert 30 in held("")[0] and "names no SPC" in held("")[1][0]


def test_lists_of_numbers_with_thru_by_and_except():
    assert numbers_of(["1", "thru", "9", "BY", "2", "EXCEPT", "5", "7", "20"]) == [1, 3, 9, 20]
    with pytest.raises(ValueError, match="X is not allowed"):
        numbers_of(["1", "x"])


@pytest.mark.parametrize("wrong", ["GRID,5,3,0.,0.,0.\nCORD2R,3,4,0.,0.,0.,0.,0.,1.\n,1.,0.,0.\nCORD2R,4,3,0.,0.,0.,0.,0.,1.\n,1.,0.,0.", "GRID,5,3,0.,0.,0.\nCORD2R,3,,0.,0.,0.,0.,0.,1.\n,0.,0.,2."])  # fmt: skip
def test_systems_that_place_nothing_are_refused(tmp_path, wrong):
    path = tmp_path / "plate.bdf"
    path.write_text(wrong + "\n")
    with pytest.raises(ValueError, match=r"not in itself|three points on a line"):
        read_deck(path)


def test_files_that_include_each_other_are_refused(tmp_path):
    (tmp_path / "a.bdf").write_text("GRID,1,,0.,0.,0.\nINCLUDE 'b.bdf'\n")
    (tmp_path / "b.bdf").write_text("GRID,2,,0.,0.,0.\nINCLUDE 'a.bdf'\n")
    with pytest.raises(ValueError, match=r"b\.bdf:2: a\.bdf includes itself"):
        read_deck(tmp_path / "a.bdf")
    (tmp_path / "b.bdf").write_text("GRID,2,,0.,0.,0.\n")
    assert read_deck(tmp_path / "a.bdf").node.tolist() == [1, 2]
