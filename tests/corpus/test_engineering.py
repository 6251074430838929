"""Inputs that are good number by number and cannot be meant: what an engineer confuses."""

import pytest

SPL = "sound.spectrum = spectrum.csv: spectrum.csv"
LAB = "dampers.lab.table = lab.csv"
LEAVE_OUT = (
    "; omit the row of the overall level; oaspl_db of the section sound shifts to an overall level"
)
FOOT = "panel.supports.points.Hinge.radius_m ="
SHIPPED = "or one of falcon9_cape_blankets_octave.csv, @"

# (base, what is there, what is written instead, messages after file and line)
STUDIES = [
    # places on the panel
    ("sandwich", "at_m: [0.3, 0.86]", "at_m: [0.3, 1.86]", f"{FOOT} 0.02: patch 'foot of Hinge' @"),
    ("sandwich", "at_m: [0.3, 0.86]", "at_m: [1.05, 0.65]", f"{FOOT} 0.02: patch 'foot of Hinge' @"),
    ("sandwich", "from_m: [0.2, 0]", "from_m: [0.2, 0.1]", "panel.supports.edges[0].to_m = [0.6, 0]: point 'supports.edges 1 to_m' = (0.6, 0) m: the boundary does not lead straight to it @"),
    ("sandwich", "to_m: [0.6, 0]", "to_m: [6, 0]", "panel.supports.edges[0].to_m = [6, 0]: point 'supports.edges 1 to_m' = (6, 0) m leaves the panel; @"),
    ("sandwich", "at_m: [0.75, 0.1]", "at_m: [1.05, 0.65]", "panel.masses.Box.at_m = [1.05, 0.65]: point 'Box' = (1.05, 0.65) m lies in hole 'cut-out'; points must lie on the panel"),
    ("sandwich", "P1: [0.4, 0.3]", "P1: [1.05, 0.65]", "panel.points.P1 = [1.05, 0.65]: point 'P1' = (1.05, 0.65) m lies in hole 'cut-out'; points must lie on the panel"),
    ("sandwich", "centre_m: [0.4, 0.3]", "centre_m: [1.0, 0.6]", "panel.patches.round = {centre_m: [1.0, 0.6], diameter_m: 0.2}: patch 'round' = circle of radius 0.100574 m about (1, 0.6) m lies over hole 'cut-out'; patches must lie beside holes"),
    ("sandwich", "[[0, 0], [1.5, 0], [1.5, 1.0], [0, 1.0]]", "[[0, 0], [1.5, 1.0], [1.5, 0], [0, 1.0]]", "panel.outline_m = [[0, 0], [1.5, 1.0], [1.5, 0], [0, 1.0]]: outline (0, 0), (1.5, 1), (1.5, 0), (0, 1) m, rounded by 0.08 m encloses no area"),
    ("sandwich", "[1.5, 1.0], [0, 1.0]]", "[1.5, 1.0], [0, 1.0], [0, 0]]", "panel.outline_m = [[0, 0], [1.5, 0], [1.5, 1.0], [0, 1.0], [0, 0]]: the corner (0, 0) m is given twice in a row; each is given once, and the last edge leads back to the first"),
    ("sandwich", "[1.5, 1.0], [0, 1.0]]", "[1.5, 1.0], [1.5, 1.0], [0, 1.0]]", "panel.outline_m = [[0, 0], [1.5, 0], [1.5, 1.0], [1.5, 1.0], [0, 1.0]]: the corner (1.5, 1) m is given twice in a row; @"),
    ("sandwich", "[[0, 0], [1.5, 0], [1.5, 1.0], [0, 1.0]]", "[[0, 0], [1.5, 0], [3, 0]]", "panel.outline_m = [[0, 0], [1.5, 0], [3, 0]]: outline (0, 0), (1.5, 0), (3, 0) m, rounded by 0.08 m encloses no area"),
    ("sandwich", "corner_radius_m: 0.08", "corner_radius_m: 0.8", "panel.corner_radius_m = 0.8: corner radius 0.8 m: the edge from (1.5, 0) m is 1 m long, its two arcs need 1.6 m"),
    ("sandwich", "centre_m: [1.05, 0.65]", "centre_m: [1.45, 0.65]", "panel.holes.cut-out = {centre_m: [1.45, 0.65], diameter_m: 0.24}: hole 'cut-out' = circle of radius 0.12 m about (1.45, 0.65) m is not inside the panel; @"),
    ("sandwich", "[[0.1, 0.6], [0.3, 0.6], [0.3, 0.8], [0.1, 0.7]]", "[[0.1, 0.6], [0.3, 0.8]]", "panel.patches.slanted.corners_m = [[0.1, 0.6], [0.3, 0.8]]: must have at least 3 values, not 2"),
    ("sandwich", "[[0.1, 0.6], [0.3, 0.6], [0.3, 0.8], [0.1, 0.7]]", "[[0.1, 0.6], [0.3, 0.6], [0.2, 0.6]]", "panel.patches.slanted = {corners_m: [[0.1, 0.6], [0.3, 0.6], [0.2, 0.6]]}: patch 'slanted' (0.1, 0.6), (0.3, 0.6), (0.2, 0.6) m encloses no area"),
    ("sandwich", "[[0.1, 0.6], [0.3, 0.6], [0.3, 0.8], [0.1, 0.7]]", "[[0.1, 0.6], [0.3, 0.6], [0.3, 0.6], [0.1, 0.7]]", "panel.patches.slanted.corners_m = [[0.1, 0.6], [0.3, 0.6], [0.3, 0.6], [0.1, 0.7]]: the corner (0.3, 0.6) m is given twice in a row; @"),
    ("thin", "centre_m: [0.3, 0.5]", "centre_m: [1.45, 0.5]", "panel.patches.Left wing = {centre_m: [1.45, 0.5], size_m: [0.2, 0.2]}: must lie on the panel, x 0…1.5 m, y 0…1 m; it covers x 1.35…1.55 m, y 0.4…0.6 m"),
    ("thin", "Edge: [0.1, 0.5]", "Edge: [1.6, 0.5]", "panel.points.Edge = [1.6, 0.5]: must lie on the panel, x 0…1.5 m, y 0…1 m"),
    # units that a bound cannot tell
    ("sandwich", "mass_kg: 0.2", "mass_kg: 200", "panel.masses.Box.mass_kg = 200: more than 20 times the panel itself, which weighs 4.75 kg; 200 g would be 0.2"),
    ("sandwich", "thickness_mm: 0.1\n", "thickness_mm: 100\n", "panel.section.faces = [{material: tape, thickness_mm: 100, angle_deg: 60}, {materi…: 100.2 mm thick, more than the core of 24.4 mm: faces must be thinner than the core"),
    ("sandwich", "density_kg_m3: 32", "density_kg_m3: 2.0", "panel.section.core.density_kg_m3 = 2.0: must be from 5 to 3000; 2 lb/ft³ would be 32.04"),
    ("sandwich", "      e1_gpa: 280\n        e2_gpa: 6.5", "      e1_gpa: 6.5\n        e2_gpa: 280", "panel.section.materials.tape.nu12 = 0.3: must be below sqrt(e1_gpa/e2_gpa)"),
    # what belongs together
    ("sandwich", "slanted: {damper: foil}", "slanted: {damper: foil, fill_fraction: 0.5}", "scenarios.both.layout.slanted.fill_fraction = 0.5: not allowed: the equivalent_damping_n_s_m3 of foil does not depend on the fill fraction"),
    ("sandwich", "[0.4, 0.8]\n  both", "[0.4, 0.95]\n  both", "scenarios.fill.fill_fraction[1] = 0.95: must be in the range of dampers.lab.table, 0.4 to 0.8"),
    ("sandwich", "damper: lab", "damper: Lab", "scenarios.fill.damper = Lab: must be one of dampers: lab, Tuned, foil, layer; did you mean lab?"),
    ("thin", "patch: PID-1", "patch: pid-1", "scenarios.fill.patch = pid-1: must be one of panel.patches: PID-1, Left wing; did you mean PID-1?"),
    ("sandwich", "material: foil", "material: aluminium", "panel.section.faces[1].material = aluminium: must be one of materials: tape, foil"),
    ("sandwich", "thickness_mm: 24.4", "thickness_mm: 24.4\n      grade: 3/16-5056-0.0007", "panel.section.core = {shear_modulus_l_mpa: 186, shear_modulus_w_mpa: 90, density_…: must have either grade, or density_kg_m3, shear_modulus_l_mpa, shear_modulus_w_mpa"),
    ("sandwich", "kind: sandwich", "kind: honeycomb", "panel.section.kind = honeycomb: must be 'thin', 'solid' or 'sandwich'"),
    ("sandwich", "kind: hinge", "kind: pinned", "panel.supports.points.Hinge.kind = pinned: must be 'hinge', 'hold_down' or 'spring'"),
    ("sandwich", "outline: free\n    holes", "outline: simply supported\n    holes", "panel.supports.outline = simply supported: must be 'simply_supported', 'simply_supported_soft', 'clamped' or 'free'"),
    ("sandwich", "oaspl_db: 150", "oaspl_db: [140, 150]", "sound.oaspl_db = [140, 150]: must be a number"),
    ("sandwich", "oaspl_db: 150", "oaspl_db: 150\n  shift_db: 3", "sound.shift_db = 3: not allowed together with oaspl_db = 150"),
    ("coupon", "depth_mm: 10", "depth_mm: 2", "coupon.particles.diameter_mm = 2.5: the largest particle, 2.5 mm, must be at most 0.9 of the cell's across_flats_mm = 6.35 and depth_mm = 2"),
    ("full", "fill_fraction: 0.6", "fill_fraction: 0.9", "scenarios.place.fill_fraction = 0.9: must be in the range of coupon.sweep, 0.4 to 0.8"),
    ("thin", "[paper_corrected]", "[DEM]", "damping.readings[0] = DEM: must be 'stated', 'dem', 'paper_corrected', 'paper_printed', 'table' or 'coupled'"),
    ("thin", "damping:\n  readings: [paper_corrected]", "damping: 0.02", "damping = 0.02: must be a mapping with keys readings, level, table, interpolation, coupled, tones"),
    # what YAML makes of it
    ("thin", "sound:\n  spectrum: spectrum.csv\n  oaspl_db: 150\n  field: diffuse\n  speed_m_s: 343\n  air_density_kg_m3: 1.2\n", "  sound: {spectrum: spectrum.csv}\n", "sound: missing", "panel.sound = {spectrum: spectrum.csv}: unknown key; sound is a top-level section; do not indent its line"),
    ("thin", "spectrum: spectrum.csv", 'spectrum: "C:\\data\\spl.csv"', "not YAML: a '\\' within double quotes; write a path with '/', or in single quotes"),
    ("thin", "spectrum: spectrum.csv", "spectrum: C:\\data\\spl.csv", f"sound.spectrum = C:\\data\\spl.csv: no such file; must be a path relative to the study, {SHIPPED}"),
    ("thin", "spectrum: spectrum.csv", "spectrum: spl.xlsx", f"sound.spectrum = spl.xlsx: no such file; must be a path relative to the study, {SHIPPED}"),
    ("thin", "oaspl_db: 150", "oaspl_db:150", "not YAML: a key without ':'"),
    ("thin", "  oaspl_db: 150", "\toaspl_db: 150", "not YAML: a tab; indent with spaces"),
]  # fmt: skip

OCTAVES = "center_hz,spl_db\n63,124\n125,130\n250,131\n500,127\n"
# (base, file, its content from that of the base, messages after the key)
FILES = [
    ("thin", "spectrum.csv", lambda _: f"{OCTAVES}OASPL,137.5\n", f"{SPL}, line 6: center_hz = 'OASPL': must be a finite number{LEAVE_OUT}"),
    ("thin", "spectrum.csv", lambda _: f"{OCTAVES}0,137.5\n", f"{SPL}, line 6: center_hz = 0: must be above 0{LEAVE_OUT}"),
    ("thin", "spectrum.csv", lambda _: OCTAVES.replace(",", " "), f"{SPL}, line 1: columns must be separated by ',', not by blanks"),
    ("thin", "spectrum.csv", lambda _: OCTAVES.replace("0\n", "0,5\n"), f"{SPL}, line 3: has 3 values, must have 2 as the header (decimal commas?)"),
    ("thin", "spectrum.csv", lambda _: OCTAVES.replace("125,130", "125,130\n125,130"), f"{SPL}, line 4: center_hz = 125 appears twice; centres must increase"),
    ("thin", "spectrum.csv", lambda _: OCTAVES.replace("125,", "80,126\n100,128\n125,"), f"{SPL}, line 6: between 125 and 250 Hz there is a gap; third octave bands must adjoin", f"{SPL}, line 7: between 250 and 500 Hz there is a gap; third octave bands must adjoin"),
    ("thin", "spectrum.csv", lambda _: OCTAVES.replace("63,124", "Frequency [Hz],SPL [dB]").replace("center_hz,spl_db\n", ""), f"{SPL}, line 1: column 'Frequency [Hz]': unknown; allowed are center_hz, spl_db", f"{SPL}, line 1: column 'SPL [dB]': unknown; did you mean spl_db?"),
    ("thin", "spectrum.csv", lambda _: OCTAVES.replace("500,127", "500,127\n1k,120"), f"{SPL}, line 6: center_hz = '1k': must be a finite number"),
    ("sandwich", "lab.csv", lambda text: text.replace(",100,", ",0.1,").replace(",400,", ",0.4,"), f"{LAB}: its frequencies are 0.1 to 0.4 Hz, all outside those of the response, 100 to 400 Hz; in kHz?"),
    ("sandwich", "lab.csv", lambda text: text.replace("\n0.4,", "\n40,").replace("\n0.8,", "\n80,"), f"{LAB}: lab.csv, line 3: fill_fraction = 40: must be above 0 and at most 1 (in percent?); likewise in lines 4 to 10"),
    ("sandwich", "lab.csv", lambda text: text.replace(".", ","), f"{LAB}: lab.csv, line 3: has 7 values, must have 5 as the header (decimal commas?); likewise in lines 4 to 10"),
    ("sandwich", "lab.csv", lambda text: text.replace("5.1", "5100").replace("2.2", "2200"), f"{LAB}: lab.csv, line 3: apparent_mass_kg_m2 = 5100: must be at least -1000 and at most 1000 (in g/m²?)", f"{LAB}: lab.csv, line 5: apparent_mass_kg_m2 = 2200: must be at least -1000 and at most 1000 (in g/m²?)"),
    ("sandwich", "lab.csv", lambda text: text.replace("0.4,100,1,820", "0.4,100,1,900,5\n0.4,100,1,820"), f"{LAB}: lab.csv, line 4: fill_fraction = 0.4, frequency_hz = 100, acceleration_g = 1: duplicate of line 3"),
    ("file", "panel.bdf", lambda text: text.replace("CQUAD4,1,1,1,2,6,5", "CQUAD4,1,1,1,2,5,6"), "panel.mesh.file = panel.bdf: element 1: its corners do not form a convex quadrilateral"),
    ("file", "panel.bdf", lambda text: text.replace("CQUAD4,3,1,3,4,8,7", "CQUAD4,3,1,13,4,8,14").replace("ENDDATA", "GRID,13,,800.0,0.0,0.0\nGRID,14,,800.0,400.0,0.0\nENDDATA"), "panel.mesh.file = panel.bdf: nodes 3 and 13 are at one place (800, 0) m: the panel is cracked there; merge them"),
    ("file", "panel.bdf", lambda text: text.replace("GRID,6,,400", "GRID,6,3,400"), "panel.mesh.file = panel.bdf: panel.bdf:8: GRID: CP = 3 is not read; allowed is blank (positions in the basic system, supports in the study)"),
    ("file", "panel.bdf", lambda text: text.replace("400.0,400.0,0.0", "400,0,400,0,0,0"), "panel.mesh.file = panel.bdf: node 6: z = 400, others have 0; the panel must be plane, in x and y"),
    ("file", "panel.bdf", lambda _: "1    MSC NASTRAN  JOB\n", "panel.mesh.file = panel.bdf: panel.bdf:1: card 1    MSC is not read; allowed are GRID, CTRIA3, @"),
]  # fmt: skip


def compare(told, says):
    """Assert what is told after file and line: whole, or up to ``@``."""
    assert len(told) == len(says), told
    for line, expected in zip(told, says, strict=True):
        said = line.split(": ", 1)[1]
        assert said.startswith(expected[:-1]) if expected.endswith("@") else said == expected


@pytest.mark.parametrize("case", STUDIES, ids=lambda case: f"{case[0]}: {case[2][:50]!r}")
def test_what_an_engineer_confuses_is_told(written, bases, change, case):
    # red: _check_layouts, _check_masses or _check_range without its yield
    base, old, new, *says = case
    compare(written(change(bases[base], old, new)).told(), says)


@pytest.mark.parametrize("case", FILES, ids=lambda case: f"{case[1]}: {case[3][-40:]!r}")
def test_what_an_engineer_confuses_in_a_file_is_told(written, folder, bases, files, case):
    # red: _of_overall without its condition; `_told_once` that returns all
    base, name, content, *says = case
    path = folder / name
    try:
        path.write_text(content(files[name]), encoding="utf-8")
        told = written(bases[base]).told()
    finally:
        path.write_text(files[name], encoding="utf-8")
    compare(told, says)


def test_mistakes_between_sections_are_told_beside_those_within(written, bases, change):
    # red: no partial_study in checked_study; `of_fills=True` for dampers that are wrong
    study = change(bases["sandwich"], "damping_ratio: 0.01", "damping_ratio: 1")
    study = change(study, "loss_factor: 0.1", "loss_factor: 10")
    study = change(study, "damper: lab", "damper: Lab")
    study = change(study, "slanted: {damper: foil}", "slantd: {damper: foil}")
    assert [one.split(": ")[1].split(" = ")[0] for one in written(study).told()] == [
        "panel.damping_ratio",
        "dampers.layer.loss_factor",
        "scenarios.fill.damper",
        "scenarios.both.layout.slantd",
    ]


def test_a_cell_has_one_fill_and_may_lie_under_a_blanket(written, bases, change):
    # red: `if filled.fill_fraction is not None` left out of _check_layouts
    study = change(bases["sandwich"], "centre_m: [0.4, 0.3]", "centre_m: [0.2, 0.65]")
    assert written(study).told() == []
    study = change(study, "round: {damper: Tuned}", "round: {damper: lab, fill_fraction: 0.5}")
    assert written(study).told() == []
    study = change(study, "slanted: {damper: foil}", "slanted: {damper: lab, fill_fraction: 0.6}")
    (said,) = written(study).told()
    assert said.endswith("covers cells of round too; a cell has only one fill fraction")


def test_the_fills_of_a_table_are_compared_though_the_panel_is_wrong(written, bases, change):
    # red: no _check_tables of the partial study
    study = change(bases["sandwich"], "damping_ratio: 0.01", "damping_ratio: 1")
    study = change(study, "[0.4, 0.8]\n  both", "[0.4, 0.95]\n  both")
    assert [one.split(": ")[1].split(" = ")[0] for one in written(study).told()] == [
        "panel.damping_ratio",
        "scenarios.fill.fill_fraction[1]",
    ]


def test_a_section_that_is_missing_brings_no_mistakes_of_others(written, bases, change):
    # red: `if panel or patches` left out of partial_study
    told = written(change(bases["thin"], "panel:\n", "panl:\n")).told()
    assert [one.split(": ", 1)[1].partition(" = ")[0] for one in told] == ["panel: missing", "panl"]
