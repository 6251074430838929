"""`pidpanel new`: what a study takes from files: a Nastran deck, limits."""

import re
from pathlib import Path

import pytest

from pidpanel.cli import main
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.study import load_study

NX, NY, EDGE = 6, 4, 200  # elements, and their edge [mm]
# plies of carbon (1) on a core (2): thickness [mm] and angle
FACE = [(1, 0.2, 0), (1, 0.1, 60)]
STACK = [*FACE, (2, 20, 0), *FACE[::-1]]
MATERIALS = [
    "MAT8,1,{0:g},{1:g},.3,{2:g},,,{3:g}", "MAT8,2,{4:g},{4:g},.3,{4:g},{5:g},{6:g},{7:g}"
]  # fmt: skip
PASCALS = (280e9, 6.5e9, 4.5e9, 1600.0, 1e6, 186e6, 90e6, 32.0)


def node(i, j):
    return 100 + j * (NX + 1) + i


def deck(cards=(), unit=1e-3, stack=STACK, fields="", nsm=0.8):
    """A deck of 1.2 m × 0.8 m with a sandwich, in t, mm and s, or in SI units."""
    length, scale = 1e-3 / unit, unit**2 if unit < 1 else 1.0
    density = 1e-12 if unit < 1 else 1.0
    factors = (scale, scale, scale, density, scale, scale, scale, density)
    values = [value * factor for value, factor in zip(PASCALS, factors, strict=True)]
    lines = ["SOL 103", "CEND", "BEGIN BULK"]
    lines += [
        f"GRID,{node(i, j)},,{i * EDGE * length!r},{j * EDGE * length!r},0."
        for j in range(NY + 1)
        for i in range(NX + 1)
    ]
    lines += [
        f"CQUAD4,{1 + j * NX + i},7,{node(i, j)},{node(i + 1, j)},{node(i + 1, j + 1)},{node(i, j + 1)}"
        for j in range(NY)
        for i in range(NX)
    ]
    mass = nsm * density / unit if unit < 1 else nsm
    lines.append(f"PCOMP,7,,{mass!r},,,,,{fields}")
    lines += [f",{number},{thick * length!r},{angle:g}.,YES" for number, thick, angle in stack]
    lines += [row.format(*values) for row in MATERIALS]
    return "\n".join([*lines, *cards, "ENDDATA"]) + "\n"


@pytest.fixture
def drafted(tmp_path, monkeypatch, capsys):
    """(deck, options) → the panel of the study that is written, in a folder of its own."""
    monkeypatch.chdir(tmp_path)

    def panel(text, *options):
        (tmp_path / "deck.bdf").write_text(text)
        status = main(["new", "mine.yaml", "--force", "--mesh", "deck.bdf", *options])
        assert status == 0, capsys.readouterr().err
        return load_study(tmp_path / "mine.yaml").panel

    return panel


def test_the_section_of_a_deck_has_the_mass_and_stiffness_of_its_plies(drafted):
    panel = drafted(deck())
    assert panel.section.faces is not None  # the same from both sides
    section = StudiedPanel(panel).section
    # Σ ρ t, and 0.8 kg/m² of the field NSM
    assert section.mass_per_area == pytest.approx(4 * 0.15e-3 * 1600 + 20e-3 * 32 + 0.8)
    moduli = section.core
    assert (moduli.shear_modulus_l, moduli.shear_modulus_w) == pytest.approx((186e6, 90e6))


@pytest.mark.parametrize(
    "other",
    [
        deck(unit=1.0),
        deck(stack=[*FACE, (2, 10, 0)], fields="SYM"),
        deck(stack=[*FACE, (2, 5, 0), (2, 15, 0), *FACE[::-1]]),
    ],
    ids=["metres", "symmetric", "two cores"],
)
def test_the_same_sandwich_written_otherwise_is_the_same_panel(drafted, other):
    first, second = drafted(deck()), drafted(other)
    assert second.section == first.section
    assert StudiedPanel(second).area.bounds == pytest.approx((0, 0, 1.2, 0.8))


def test_faces_that_differ_are_stated_from_outside(drafted):
    section = drafted(deck(stack=[*FACE, (2, 20, 0), (1, 0.3, 90)])).section
    assert [ply.angle_deg for ply in section.plies("bottom")] == [0, 60]
    assert [ply.thickness_mm for ply in section.plies("top")] == [0.3]


def test_constraints_of_whole_sides_are_edges_and_others_points(drafted):
    left = ",".join(str(node(0, j)) for j in range(NY + 1))
    cards = [
        f"SPC1,1,123,{left}",
        f"SPC1,1,123456,{node(0, NY)},THRU,{node(NX, NY)}",
        f"SPC,1,{node(3, 1)},123,0.",
        f"SPC1,1,12,{node(5, 1)}",  # holds nothing across the plane
    ]
    supports = drafted(deck(cards)).support_input
    assert supports.outline == "free"
    sides = {(edge.from_m, edge.to_m): edge.kind for edge in supports.edges}
    assert {frozenset(side): kind for side, kind in sides.items()} == {
        frozenset({(0, 0), (0, 0.8)}): "simply_supported",
        frozenset({(0, 0.8), (1.2, 0.8)}): "clamped",
    }
    assert [(point.grid, point.kind) for point in supports.points.values()] == [
        (node(3, 1), "hinge")
    ]


def test_a_deck_held_all_round_is_held_at_its_outline(drafted):
    rim = {node(i, j) for i in range(NX + 1) for j in range(NY + 1) if i in (0, NX) or j in (0, NY)}
    cards = [f"SPC1,1,3,{number}" for number in rim]
    supports = drafted(deck(cards)).support_input
    assert supports.outline == "simply_supported"
    assert not supports.edges and not supports.points


@pytest.mark.parametrize("style", ["one list", "GRID"])
def test_all_nodes_of_a_long_constraint_are_held(drafted, style):
    rim = [(i, j) for i in range(NX + 1) for j in range(NY + 1) if i in (0, NX) or j in (0, NY)]
    nodes = [*map(str, range(9000, 9080)), *(str(node(i, j)) for i, j in rim)]
    text = deck()
    if style == "GRID":
        for number in nodes[80:]:
            text = re.sub(rf"(GRID,{number},.*)", r"\1,,3", text)
    else:
        rows = [",".join(nodes[k : k + 8]) for k in range(6, len(nodes), 8)]
        lines = ["SPC1,1,3," + ",".join(nodes[:6]), *(f"+,{row}" for row in rows)]
        text = text.replace("ENDDATA", ",+\n".join(lines) + ",+\nENDDATA")
    supports = drafted(text).support_input
    assert supports.outline == "simply_supported" and not supports.points


def test_fields_behind_the_eighth_of_a_constraint_are_refused(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    nodes = ",".join(str(node(i, 0)) for i in range(NX + 1))
    (tmp_path / "deck.bdf").write_text(deck([f"SPC1,1,3,{nodes}"]))
    assert main(["new", "mine.yaml", "--mesh", "deck.bdf"]) == 2
    said = capsys.readouterr().err
    assert f"SPC1: '{node(NX, 0)}'" in said and said.count("\n") == 1


def test_a_size_beside_a_mesh_is_refused_in_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "mine.yaml", "--mesh", "deck.bdf", "--size", "3x3"]) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--size" in line and "deck.bdf" in line and not Path("mine.yaml").exists()


def test_a_short_line_of_a_laminate_is_continued_at_its_ninth_field(drafted):
    short = deck(nsm=0.8).replace(",,,,,\n", ",+\n", 1)
    assert ",+\n" in short
    assert drafted(short).section == drafted(deck()).section


def test_point_masses_are_those_of_the_deck_in_kg(drafted):
    panel = drafted(deck([f"CONM2,900,{node(2, 2)},,2.5-4"]))
    assert [(m.grid, m.mass_kg) for m in panel.masses.values()] == [(node(2, 2), 0.25)]


def test_masses_of_a_deck_whose_section_is_not_read_are_named(drafted, capsys):
    mass = f"CONM2,900,{node(NX // 2, NY // 2)},,5.-4"
    assert drafted(deck([mass])).masses and "masses" not in capsys.readouterr().out
    assert not drafted(deck([mass, "PCOMP,8", ",1,1.,0.,YES"])).masses
    assert "masses" in capsys.readouterr().out


def test_elements_of_a_coarse_deck_are_divided_until_a_run_can_use_them(drafted, capsys):
    drafted(deck())
    assert main(["check", "mine.yaml"]) == 0
    assert "about" in capsys.readouterr().out


def test_a_deck_that_cannot_be_read_is_told_in_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "deck.bdf").write_text(deck(["CQUAD8,90,7,100,101,108,107"]))
    for name, words in (("deck.bdf", "CQUAD8"), ("nosuch.bdf", "nosuch.bdf: ")):
        assert main(["new", "mine.yaml", "--mesh", name]) == 2
        said = capsys.readouterr().err
        assert words in said and said.count("\n") == 1
    assert not (tmp_path / "mine.yaml").exists()


# ------------------------------------------------------------------ limits


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        (["25"], {"P1": (25, None), "P2": (25, None)}),
        (["P1=25", "P2=30"], {"P1": (25, None), "P2": (30, None)}),
        (["30", "P1=25"], {"P1": (25, None), "P2": (30, None)}),
        (["P2=limit.csv", "P2=25"], {"P2": (25, "limit.csv")}),
    ],
)
def test_limits_hold_at_the_point_that_they_name_or_at_all(tmp_path, monkeypatch, given, expected):
    monkeypatch.chdir(tmp_path)
    table = "frequency_hz,acceleration_psd_g2_hz\n30,0.5\n2000,0.5\n"
    (tmp_path / "limit.csv").write_text(table)
    options = [word for limit in given for word in ("--limits", limit)]
    assert main(["new", "mine.yaml", *options]) == 0
    limits = load_study(tmp_path / "mine.yaml").limits
    found = {point: (limit.rms_g, limit.psd and limit.psd.name) for point, limit in limits.items()}
    assert found == expected


def test_a_limit_at_no_point_is_told_in_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["new", "mine.yaml", "--limits", "A9=25"]) == 2
    said = capsys.readouterr().err
    assert "limits" in said and "A9" in said and said.count("\n") == 1
