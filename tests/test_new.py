"""`pidpanel new`: what a study takes from files: a Nastran deck, limits."""

import re
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg

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


def test_a_step_file_is_named_as_the_shape_of_a_structure(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "dish.STEP").write_text("ISO-10303-21;")
    assert main(["new", "mine.yaml", "--mesh", "dish.STEP"]) == 2
    assert (
        "--mesh: dish.STEP: no mesh; a study names it in structure.shell.form"
        in capsys.readouterr().err
    )
    assert not (tmp_path / "mine.yaml").exists()


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
    assert not drafted(deck([mass]).replace("MAT8,1,", "MAT2,1,")).masses
    assert "point masses are left out" in capsys.readouterr().out


def test_elements_of_a_coarse_deck_are_divided_until_a_run_can_use_them(drafted, capsys):
    drafted(deck())
    assert main(["check", "mine.yaml"]) == 0
    assert "about" in capsys.readouterr().out


def test_a_deck_too_coarse_for_all_of_the_sound_is_computed_as_far_as_it_goes(drafted):
    text = deck(unit=1.0).split("PCOMP")[0]
    panel = drafted(f"{text}PSHELL,7,1,0.0001,1\nMAT1,1,7.+10,,.33,2700.\nENDDATA\n")
    assert panel.mesh.refine == 4
    highest = load_study("mine.yaml").response.frequency_hz[1]
    assert 60 < highest < 2000


def test_a_deck_that_cannot_be_read_is_told_in_one_line(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "deck.bdf").write_text(deck(["CSHEAR,90,7,100,101,108,107"]))
    for name, words in (("deck.bdf", "CSHEAR"), ("nosuch.bdf", "nosuch.bdf: ")):
        assert main(["new", "mine.yaml", "--mesh", name]) == 2
        said = capsys.readouterr().err
        assert words in said and said.count("\n") == 1
    assert not (tmp_path / "mine.yaml").exists()


def tilted(text, turn):
    """The deck with its nodes turned in space."""

    def place(match):
        x = [float(match[k]) for k in (2, 3)]
        return f"GRID,{match[1]},," + ",".join(f"{v!r}" for v in (turn[:, :2] @ x).tolist())

    return re.sub(r"GRID,(\d+),,([^,]+),([^,]+),0\.", place, text)


def abd(panel):
    section = StudiedPanel(panel).section
    return np.concatenate([part.ravel() for part in (*section.abd, section.shear)])


@pytest.mark.parametrize("seen", ["tilted", "from below", "by MCID", "by THETA"])
def test_the_same_deck_in_another_view_is_the_same_panel(drafted, seen):
    stack = [*FACE, (2, 20, 30), (1, 0.3, 15)]
    rim = [node(i, 0) for i in range(NX + 1)]
    cards = [f"SPC1,1,3,{number}" for number in rim]
    panel, text = drafted(deck(cards, stack=stack)), deck(cards, stack=stack)
    if seen == "tilted":  # held along the normal in the frame of its nodes
        turn = scipy.linalg.expm(np.cross(np.eye(3), [-0.7, 0, 0]))
        points = ",".join(f"{v!r}" for v in [0.0, 0.0, 0.0, *turn[:, 2].tolist()])
        cards = [*cards, f"CORD2R,3,,{points}", ",1.,0.,0."]
        text = tilted(deck([*cards, "GRDSET,,,,,,3"], stack=stack), turn)
    elif seen == "from below":  # corners the other way round, plies from the other side
        text = deck(cards, stack=[(m, t, -a) for m, t, a in stack[::-1]])
        text = re.sub(r"(CQUAD4,\d+,7),(\d+),(\d+),(\d+),(\d+)", r"\1,\3,\2,\5,\4", text)
    elif seen == "by MCID":  # a system whose x is 50° from that of the panel
        x = np.radians(50)
        cards = [*cards, "CORD2R,8,,0.,0.,0.,0.,0.,1.", f",{np.cos(x):.9f},{np.sin(x):.9f},7."]
        text = deck(cards, stack=[(m, t, a - 50) for m, t, a in stack])
        text = re.sub(r"(CQUAD4,.*)", r"\1,8", text)
    else:
        text = deck(cards, stack=[(m, t, a + 25) for m, t, a in stack])
        text = re.sub(r"(CQUAD4,.*)", r"\1,-25.", text)
    other = drafted(text)
    np.testing.assert_allclose(abd(other), abd(panel), rtol=1e-5, atol=1e-6)
    kinds = [[edge.kind for edge in p.support_input.edges] for p in (panel, other)]
    assert kinds == [["simply_supported"]] * 2


def test_materials_in_different_directions_give_no_section(drafted, capsys):
    text = re.sub(r"(CQUAD4,3,.*)", r"\1,40.", deck())
    assert drafted(text).section.core.grade is not None
    assert "differ by 40°" in capsys.readouterr().out


METALS = {1.0: ("7.+10", "2700."), 1e-3: ("7.+4", "2.7-9"), 0.0254: ("1.0152636+7", "2.5265-4")}


@pytest.mark.parametrize("unit", METALS)
def test_a_plate_of_a_pshell_tells_the_unit_and_is_solid(drafted, unit):
    E, density = METALS[unit]
    text = deck(unit=unit).split("PCOMP")[0]
    text += f"PSHELL,7,1,{0.002 / unit!r},1\nMAT1,1,{E},,.33,{density}\nENDDATA\n"
    section = drafted(text).section
    assert section.properties == pytest.approx((7e10, 0.33, 2700, 0.002), rel=2e-4)
    mass = drafted(text.replace(density, f"{density}\nPARAM,WTMASS,2.")).section.density_kg_m3
    assert mass == pytest.approx(5400, rel=2e-4)


def test_weights_for_densities_are_refused_in_the_unit_of_the_moduli(drafted, capsys):
    text = deck(unit=0.0254).split("PCOMP")[0]
    text += "PSHELL,7,1,.08,1\nMAT1,1,1.05+7,,.33,.101\nENDDATA\n"  # lbf/in³
    panel = drafted(text)
    assert panel.mesh.unit_m == 0.0254 and panel.section.kind == "sandwich"
    assert "material 1 has 1.08e+06 kg/m³" in capsys.readouterr().out
    drafted(text.replace("MAT1,1,1.05+7", "MAT1,1,1.05+20"))
    assert "by the extent alone" in capsys.readouterr().out


def test_a_sandwich_of_a_pshell_has_its_bending_shear_and_mass(drafted):
    faces, depth, core = 0.6e-3, 20e-3, 90e6  # both faces, core [m], shear modulus [Pa]
    d = depth + faces / 2
    inertia = 12 * (faces * d**2 / 4 + faces**3 / 48) / faces**3
    text = deck(unit=1.0).split("PCOMP")[0]
    ratio = core * d**2 / depth / core / faces  # TS/T with the modulus of the core
    text += f"PSHELL,7,1,{faces!r},1,{inertia!r},2,{ratio!r},1.2\n"
    text += f"MAT1,1,7.+10,,.33,2700.\nMAT1,2,,{core!r},.3\nENDDATA\n"
    section = StudiedPanel(drafted(text)).section
    assert section.mass_per_area == pytest.approx(2700 * faces + 1.2)
    D = 7e10 / (1 - 0.33**2) * inertia * faces**3 / 12
    assert section.bending[0, 0] == pytest.approx(D, rel=1e-5)
    assert section.shear[0, 0] == pytest.approx(core * d**2 / depth, rel=1e-5)


@pytest.mark.parametrize(
    ("old", "new", "reason"),
    [
        ("MAT8,1,", "MAT2,1,", "material 1 is MAT2, which is not read"),
        (",1.6e-09", ",1.6e-15", "material 1 has 0.0016 kg/m³"),
        (",2,20.0,", ",1,20.0,", "no soft core between faces"),
        ("PCOMP,7,,", "PCOMP,7,0.,", "Z0 = 0. is not half its thickness"),
    ],
)
def test_what_a_section_cannot_state_is_said_in_one_line(drafted, capsys, old, new, reason):
    text = deck()
    assert text.count(old) == 1
    assert drafted(text.replace(old, new), "--unit-m", "0.001").section.core.grade is not None
    lines = [line for line in capsys.readouterr().out.splitlines() if reason in line]
    assert len(lines) == 1 and "deck.bdf:" in lines[0]


def test_groups_of_a_deck_are_the_panel_of_a_new_study(drafted, capsys):
    wall = ["GRID,900,,0.,0.,500.", "GRID,901,,200.,0.,500.", "CQUAD4,900,9,100,101,901,900"]
    mass = "CONM2,902,900,,1.-3"
    panel = drafted(deck([*wall, "CBAR,903,5,900,901,0.,1.", mass]), "--group", "7")
    assert panel.mesh.groups == ("7",) and not panel.mesh.ignore
    assert len(StudiedPanel(panel).foreign.triangles) % (2 * NX * NY) == 0
    assert "1 kg that are not on the panel" in capsys.readouterr().out


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
