"""`pidpanel new --mesh` of decks that are not flat: a shell with the sections of its properties."""

from dataclasses import replace

import numpy as np
import pytest

from pidpanel.cli import main
from pidpanel.panel.modes import first_modes
from pidpanel.panel.section import SolidSection
from pidpanel.shell.assembly import assemble_shell
from pidpanel.shell.attachments import ShellSupport
from pidpanel.shell.drawing import cylinder_panel, mesh_surface
from pidpanel.shell.selections import Box
from pidpanel.shell.strains import Layup
from pidpanel.structure.any_structure import StructureRefused
from pidpanel.structure.from_study import structure_of
from pidpanel.study import load_study

RADIUS, LENGTH, ARC = 1.0, 0.6, 0.5  # [m]
FAR = 1e3
SOLID = "PSHELL,{0},9,4.,9\nMAT1,9,70000.,,.3,2.7-9"
CARBON = "MAT8,1,60000.,20000.,.3,5000.,,,1.6-9\nMAT8,2,1.,1.,.3,1.,120.,60.,5.-11"
PLIES = [(1, 0.4, 0), (1, 0.2, 30), (2, 8.0, 0), (1, 0.5, 10)]
HOOP = "CORD2R,8,,0.,0.,0.,0.,0.,1.\n,0.,1.,0."  # x along the arc


def laminate(number, plies=PLIES):
    return "\n".join([f"PCOMP,{number}", *(f",{m},{t},{a}.,YES" for m, t, a in plies)])


def node(i, j, n=8):
    return 1 + j * (n + 1) + i


def deck(*cards, n=8, direction="", parts=lambda i, j: 1, turned=lambda i, j: False):
    """A cylinder panel about x of n × n elements, clamped at both ends, in t, mm and s."""
    x, s = np.meshgrid(np.linspace(0, LENGTH, n + 1), np.linspace(-ARC / 2, ARC / 2, n + 1))
    places = [x.ravel(), RADIUS * np.sin(s.ravel() / RADIUS), RADIUS * np.cos(s.ravel() / RADIUS)]
    lines = ["BEGIN BULK"]
    for k, place in enumerate(1e3 * np.transpose(places), 1):
        lines.append(f"GRID,{k},," + ",".join(f"{v:.9g}" if v else "0." for v in place))
    for j in range(n):
        for i in range(n):
            a, b, c, d = (node(i + u, j + v, n) for u, v in ((0, 0), (1, 0), (1, 1), (0, 1)))
            corners = (b, a, d, c) if turned(i, j) else (a, b, c, d)
            head = f"CQUAD4,{1 + j * n + i},{parts(i, j)},"
            lines.append(head + ",".join(map(str, corners)) + direction)
    for i in (0, n):
        lines += [f"SPC1,1,123456,{node(i, j, n)}" for j in range(n + 1)]
    return "\n".join([*lines, *cards, "ENDDATA", ""])


@pytest.fixture
def drafted(tmp_path, monkeypatch, capsys):
    """(deck) → status, structure of the study or None, what was printed."""
    monkeypatch.chdir(tmp_path)

    def draft(text):
        (tmp_path / "deck.bdf").write_text(text)
        status = main(["new", "mine.yaml", "--force", "--mesh", "deck.bdf"])
        printed = capsys.readouterr()
        panel = load_study(tmp_path / "mine.yaml").panel if status == 0 else None
        return status, panel, printed.out + printed.err

    return draft


def test_facets_of_a_cylinder_have_the_frequencies_of_the_curved_shell(drafted):
    _, structure, _ = drafted(deck(SOLID.format(1), n=12))
    ends = [Box((-FAR,) * 3, (0, FAR, FAR)), Box((LENGTH, -FAR, -FAR), (FAR,) * 3)]
    shell = assemble_shell(
        mesh_surface(cylinder_panel(RADIUS, LENGTH, ARC), 0.08),
        Layup(SolidSection(70e9, 0.3, 2700.0, 4e-3)),
        {str(k): ShellSupport(box) for k, box in enumerate(ends)},
    )
    expected = first_modes(shell, 6)[1]
    frequency = structure_of(structure).first_frequency
    # what `MOST_BULGE` allows, and 0.1 % of elements of order 3
    np.testing.assert_allclose(frequency, expected, rtol=4e-3)


def test_facets_too_coarse_for_a_thin_shell_are_refused(drafted):
    status, _, printed = drafted(deck(SOLID.format(1).replace("4.", "1.")))
    assert status == 2 and "flat facets are up to" in printed and printed.count("\n") == 1


def test_a_file_with_longer_elements_than_stated_is_refused(drafted):
    _, structure, _ = drafted(deck(SOLID.format(1), n=12))
    shell = replace(structure_of(structure), size=0.02)
    shell.check(1000.0)
    with pytest.raises(StructureRefused, match=r"elements are 0\.052 m long, at most 0\.04\d* m"):
        shell.check(6000.0)


def test_materials_along_the_radius_of_a_cylinder_are_refused(drafted):
    radial = "CORD2C,8,,0.,0.,0.,1.,0.,0.\n,0.,0.,1."
    _, structure, printed = drafted(deck(laminate(1), CARBON, radial, direction=",8"))
    assert "element 1: the x axis of MCID 8 is along its normal" in printed
    assert structure.shell.section.core.grade  # not its own


def frequencies(structure):
    return structure_of(structure).first_frequency


@pytest.mark.parametrize("seen", ["by MCID", "by THETA", "from below", "from below by THETA"])
def test_a_laminate_is_the_same_however_its_elements_state_it(drafted, seen):
    common = CARBON, HOOP
    _, original, _ = drafted(deck(laminate(1), *common, direction=",8"))
    below = [(m, t, -a) for m, t, a in PLIES[::-1]]
    text = {
        "by MCID": lambda: deck(laminate(1, [(m, t, a - 90) for m, t, a in PLIES]), CARBON,
                                "CORD2R,8,,0.,0.,0.,0.,0.,1.\n,1.,0.,0.", direction=",8")
                           .replace("CORD2R,8,,0.,0.,0.,0.,0.,1.\n,1.", "CORD2R,8,,0.,0.,0.,0.,0.,1.\n,-1."),
        "by THETA": lambda: deck(laminate(1), *common, direction=",90."),
        "from below": lambda: deck(laminate(1, below), *common, direction=",8",
                                   turned=lambda i, j: True),
        "from below by THETA": lambda: deck(laminate(1, below), *common, direction=",90.",
                                            turned=lambda i, j: True),
    }[seen]()  # fmt: skip
    _, other, _ = drafted(text)
    np.testing.assert_allclose(frequencies(other), frequencies(original), rtol=1e-6)
    plain = drafted(deck(laminate(1), *common))[1]
    assert abs(frequencies(plain)[0] / frequencies(original)[0] - 1) > 0.02  # 90° away


def test_properties_are_parts_with_sections_of_their_own(drafted):
    halves = deck(
        laminate(1), laminate(2, [(1, 1.0, 0), (2, 8.0, 0), (1, 1.0, 0)]), CARBON, HOOP,
        direction=",8", parts=lambda i, j: 1 + (i > 4),
    )  # fmt: skip
    _, structure, printed = drafted(halves)
    assert set(structure.shell.parts) == {"2"} and "2 properties" in printed
    # Σ ρ t over 5 and 3 columns of elements
    masses = [1600 * 1.1e-3 + 50 * 8e-3, 1600 * 2e-3 + 50 * 8e-3]
    mass = structure_of(structure).section.mass_per_area
    assert mass == pytest.approx((5 * masses[0] + 3 * masses[1]) / 8, rel=1e-6)


def test_supports_feet_and_masses_of_a_deck_are_proposed(drafted):
    cards = [
        SOLID.format(1), "GRID,900,,300.,0.,1100.", "RBE2,901,900,123456,40,41,42",
        "CONM2,902,900,,1.5-3", f"CONM2,903,{node(2, 2)},,.25-3", "CONM2,904,900,,.5-3",
        "GRID,905,,0.,0.,0.", "CONM2,906,905,,3.-3", f"SPC1,1,3,{node(4, 1)}",
    ]  # fmt: skip
    text = deck(*cards).replace("PSHELL,1,9,4.", "PSHELL,1,9,9.")
    _, structure, printed = drafted(text)
    shell = structure.shell
    assert sorted(part.kind for part in shell.supports.values()) == ["clamped", "clamped"]
    (foot,) = shell.feet.values()
    assert (foot.kind, foot.mass_kg, foot.centre_m) == ("free", 2.0, (0.3, 0, 1.1))
    (mass,) = shell.masses.values()
    assert mass.mass_kg == 0.25
    assert "a mass of 3 kg at node 905 is left out" in printed
    assert f"1 nodes held in some directions are left free ({node(4, 1)})" in printed


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (lambda text: text.replace("MAT8,1", "MAT2,1"), "material 1 is MAT2"),
        (lambda text: text.replace("CQUAD4,20,1,", "CQUAD4,20,1,").replace(
            "1,2,11,10,8", "2,1,10,11,8"), "normals of its elements are on both sides"),
        (lambda text: text.replace("1,2,11,10,8", "1,2,11,10,45."), "off one direction in space"),
    ],
)  # fmt: skip
def test_what_a_section_cannot_state_is_said(drafted, change, reason):
    status, _, printed = drafted(change(deck(laminate(1), CARBON, HOOP, direction=",8")))
    assert status == 0 and reason in printed and "not its own" in printed


def test_offsets_of_elements_are_those_of_sections(drafted):
    common = laminate(1, [(1, 1.0, 0), (2, 8.0, 0), (1, 1.0, 0)]), CARBON, HOOP
    _, above, _ = drafted(deck(*common, direction=",,2."))
    _, below, _ = drafted(deck(*common, direction=",,-2.", turned=lambda i, j: True))
    assert above.shell.offset_m == pytest.approx(below.shell.offset_m) == pytest.approx(2e-3)
    np.testing.assert_allclose(frequencies(below), frequencies(above), rtol=1e-6)
    plain = drafted(deck(*common))[1]
    assert abs(frequencies(plain)[0] / frequencies(above)[0] - 1) > 1e-4
    text = deck(*common, direction=",,2.").replace(",2.", ",1.", 1)
    assert "ZOFFS differs between its elements" in drafted(text)[2]
