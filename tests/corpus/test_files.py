"""Spectra, tables and meshes that cannot be read are told line by line, at the key that names them."""

import os

import pytest

SPL = "sound.spectrum = spectrum.csv: spectrum.csv"
LAB = "dampers.lab.table = lab.csv: lab.csv"
TUNED = "dampers.Tuned.impedance = tuned.csv: tuned.csv"
BDF = "panel.mesh.file = panel.bdf: panel.bdf"
MSH = "panel.mesh.file = panel.msh: panel.msh"
UTF8 = "must be text in UTF-8"
C, F = "equivalent_damping_n_s_m3", "frequency_hz"
GRID6 = "GRID,6,,400.0,400.0,0.0"

# (base, file, what is there, what is written instead, messages after file and line of the study)
PSD = "frequency_hz,psd_pa2_hz\n"
SPECTRA = [
    ("center_hz,spl_db", "cetner_hz,spl_db", f"{SPL}, line 2: column 'cetner_hz': unknown; did you mean center_hz?"),
    ("63,124", "63,-124", f"{SPL}, line 3: spl_db = -124: must be at least -100 and at most 200"),
    ("63,124", "63,632", f"{SPL}, line 3: spl_db = 632: must be at least -100 and at most 200 (in Pa?)"),
    ("63,124", "63,nan", f"{SPL}, line 3: spl_db = 'nan': must be a finite number"),
    ("63,124", "63,inf", f"{SPL}, line 3: spl_db = 'inf': must be a finite number"),
    ("63,124", "63,", f"{SPL}, line 3: spl_db = (empty): must be a number"),
    ("63,124", "63", f"{SPL}, line 3: has 1 values, must have 2 as the header"),
    ("63,124", "63,124,5", f"{SPL}, line 3: has 3 values, must have 2 as the header (decimal commas?)"),
    ("63,124", "0,124", f"{SPL}, line 3: center_hz = 0: must be above 0"),
    ("63,124", "-63,124", f"{SPL}, line 3: center_hz = -63: must be above 0"),
    ("63,124", "66,124", f"{SPL}, line 3: center_hz = 66 is not a preferred centre; the nearest is 63.1 Hz (within 2 %)"),
    ("63,124\n80,126", "66,124\n80,x", f"{SPL}, line 3: center_hz = 66 is not a preferred centre; the nearest is 63.1 Hz (within 2 %)", f"{SPL}, line 4: spl_db = 'x': must be a finite number"),
    ("80,126", "63,126", f"{SPL}, line 4: center_hz = 63 appears twice; centres must increase"),
    ("80,126\n100,128", "100,128\n80,126", f"{SPL}, line 5: center_hz = 80 follows a higher centre; centres must increase"),
    ("125,130\n", "", f"{SPL}, line 6: between 100 and 160 Hz there is a gap; third octave bands must adjoin"),
    ("# a launch spectrum", "# band: 1/1 octave", f"{SPL}, line 1: the comment states octave bands, the centres are those of third octave bands"),
    (None, "center_hz,spl_db\n125,130\n", f"{SPL}: 1 band; at least two are needed to tell octaves from thirds"),
    (None, "center_hz,spl_db\n", f"{SPL}: no bands; at least two are needed to tell octaves from thirds"),
    (None, "", f"{SPL}: empty; the first line must name the columns"),
    (None, "# only\n# comments\n", f"{SPL}: empty; the first line must name the columns"),
    (None, "center_hz,spl_db\n" + "".join(f"{f},{p}\n" for f, p in [(63, 1.2), (80, 2.3), (100, 4.5), (125, 8.1), (160, 9.2), (200, 10.5), (250, 9.7), (315, 7.1), (400, 5.2), (500, 3.1)]),
     "sound.spectrum = spectrum.csv: its bands sum to 17.1 dB; must be from 60 to 200: are they in Pa?"),
    (None, f"{PSD}60,20\n500,-3\n", f"{SPL}, line 3: psd_pa2_hz = -3: must be above 0 and at most 4e+10"),
    (None, f"{PSD}60,20\n500,0\n", f"{SPL}, line 3: psd_pa2_hz = 0: must be above 0 and at most 4e+10"),
    (None, f"{PSD}60,20\n500,30\n400,30\n", f"{SPL}, line 4: frequency_hz = 400 follows 500; frequencies must increase"),
    (None, f"{PSD}60,20\n60,30\n500,30\n", f"{SPL}, line 3: frequency_hz = 60: a step at an end is not allowed"),
    (None, f"{PSD}60,20\n99,30\n99,40\n99,30\n500,3\n", f"{SPL}, line 4: frequency_hz = 99: more than two rows at one frequency is not allowed"),
    (None, f"{PSD}60,20\n", f"{SPL}: must have at least two break points, not 1"),
    (None, "frequncy_hz,psd_pa2_hz\n60,20\n500,30\n", f"{SPL}, line 1: column 'frequncy_hz': unknown; did you mean frequency_hz?"),
    (None, "frequency_hz,psd_db\n60,20\n500,30\n", f"{SPL}, line 1: column 'psd_db': unknown; allowed are frequency_hz, psd_pa2_hz"),
    (None, f"{PSD}60,1e-9\n500,1e-9\n", "sound.spectrum = spectrum.csv: its rows sum to 30.4 dB; must be from 60 to 200: are they in Pa?"),
    (None, b"PK\x03\x04\x00\x00", f"{SPL}, line 1: {UTF8}; it has a byte 0x00, as of a binary file"),
    (None, "center_hz,spl_db\n" + "".join(f"{60 + k},900\n" for k in range(30)), *("@@",)),
]  # fmt: skip
TABLES = [
    ("fill_fraction,", "fill_fractoin,", f"{LAB}, line 2: column 'fill_fractoin': unknown; did you mean fill_fraction?"),
    ("fill_fraction,", "fill,", f"{LAB}, line 2: column 'fill': unknown; did you mean fill_fraction?"),
    (F, "freq_hz", f"{LAB}, line 2: column 'freq_hz': unknown; did you mean frequency_hz?"),
    (F, "FREQUENCY_HZ", f"{LAB}, line 2: column 'FREQUENCY_HZ': unknown; did you mean frequency_hz?"),
    (C, "damping", f"{LAB}, line 2: column 'damping': unknown; allowed are@", "@@"),
    (C, "c_e", f"{LAB}, line 2: column 'c_e': unknown; allowed are@", "@@"),
    ("acceleration_g", "acceleration_m_s2", f"{LAB}, line 2: column 'acceleration_m_s2': unknown; did you mean acceleration_g?"),
    ("apparent_mass_kg_m2", "temperature", f"{LAB}, line 2: column 'temperature': unknown; allowed are@", "@@"),
    ("fill_fraction,", "frequency_hz,", f"{LAB}, line 2: column frequency_hz: given twice"),
    (C, "loss_factor", f"{LAB}, line 2: column particle_mass_per_area_kg_m2: missing; needed with loss_factor", "@@"),
    ("0.4,100,1,820,5.1", "40,100,1,820,5.1", f"{LAB}, line 3: fill_fraction = 40: must be above 0 and at most 1 (in percent?)"),
    ("0.4,100,1,820,5.1", "0,100,1,820,5.1", f"{LAB}, line 3: fill_fraction = 0: must be above 0 and at most 1"),
    ("0.4,100,1,820,5.1", "0.4,0,1,820,5.1", f"{LAB}, line 3: frequency_hz = 0: must be above 0"),
    ("0.4,100,1,820,5.1", "0.4,100,-1,820,5.1", f"{LAB}, line 3: acceleration_g = -1: must be above 0 and at most 2000"),
    ("0.4,100,1,820,5.1", "0.4,100,1,-820,5.1", f"{LAB}, line 3: {C} = -820: must be at least 0"),
    ("0.4,100,1,820,5.1", "0.4,100,1,5e7,5.1", f"{LAB}, line 3: {C} = 5e+07: must be at most 1.26e+06 at 100 Hz: 1000 kg/m² of particles cannot dissipate more (η = 2)"),
    ("0.4,100,1,820,5.1", "0.4,100,1,nan,5.1", f"{LAB}, line 3: {C} = 'nan': must be a finite number"),
    ("0.4,100,1,820,5.1", "0.4,100,1,inf,5.1", f"{LAB}, line 3: {C} = 'inf': must be a finite number"),
    ("0.4,100,1,820,5.1", "0.4,100,1,,5.1", f"{LAB}, line 3: {C} = (empty): must be a number"),
    ("0.4,100,1,820,5.1", "0.4,100,1,820", f"{LAB}, line 3: has 4 values, must have 5 as the header"),
    ("0.4,100,1,820,5.1", "0,4,100,1,820,5,1", f"{LAB}, line 3: has 7 values, must have 5 as the header (decimal commas?)"),
    ("0.4,100,1,820,5.1", '"0,4",100,1,820,5.1', f"{LAB}, line 3: '5.1' has another mark of decimals than '0,4'"),
    ("0.4,400,1,1450,4.6", "0.4,100,1,1450,4.6", f"{LAB}, line 4: fill_fraction = 0.4, frequency_hz = 100, acceleration_g = 1: duplicate of line 3"),
    ("0.4,100,1,820,5.1\n0.4,400,1,1450,4.6", "x,100,1,820,5.1\n0.4,y,1,1450,4.6", f"{LAB}, line 3: fill_fraction = 'x': must be a finite number", f"{LAB}, line 4: frequency_hz = 'y': must be a finite number"),
    (None, "", f"{LAB}: empty; the first line must name the columns"),
    (None, f"{F},{C}\n", f"{LAB}: no rows; line 1 names the columns"),
]  # fmt: skip
SHAKER = "base.random.spectrum = shaker.csv: shaker.csv"
SHAKERS = [
    ("acceleration_psd_g2_hz", "acceleration_psd_g_hz", f"{SHAKER}, line 2: column 'acceleration_psd_g_hz': unknown; did you mean acceleration_psd_g2_hz?"),
    ("80,0.04,0", "80,0.04", f"{SHAKER}, line 4: has 2 values, must have 3 as the header"),
    ("80,0.04,0\n300", "300,0.04,0\n80", f"{SHAKER}, line 5: frequency_hz = 80 follows 300; frequencies must increase"),
    ("20,0.01,3\n80,0.04,0", "20,0.01,\n80,,", f"{SHAKER}, line 4: a gap: acceleration_psd_g2_hz is empty at 80 Hz, and no slope leads there"),
    ("20,0.01,3", "20,0.01,-3", f"{SHAKER}, line 3: slope_db_octave = -3 between 20 and 80 Hz, where the levels give +3.01"),
    ("500,0.0144,", "500,0.0144,-6", f"{SHAKER}, line 6: slope_db_octave = -6 at the last row leads nowhere; omit it"),
    ("80,0.04,0", "80,0,0", f"{SHAKER}, line 4: acceleration_psd_g2_hz = 0: must be above 0 and at most 100000"),
    (None, "frequency_hz,acceleration_psd_g2_hz\n20,0.01\n", f"{SHAKER}: must have at least two break points, not 1"),
]  # fmt: skip
IMPEDANCES = [
    (F, "freq", f"{TUNED}, line 1: column 'freq': unknown; did you mean frequency_hz?"),
    ("apparent_mass_kg_m2", "acceleration_g", f"{TUNED}, line 1: column acceleration_g: not allowed in an impedance, which holds for all; use a table", "@@"),
    ("100,820,5.1", "100,-820,5.1", f"{TUNED}, line 2: {C} = -820: must be at least 0"),
]  # fmt: skip
NASTRAN = [
    (GRID6, "GRID,6,,400.0,400.0,5.0", "panel.mesh.file = panel.bdf: node 6: z = 0.005 m, most have 0 m; the panel must be plane, in x and y"),
    (GRID6, "GRID,6,,nan,400.0,0.0", "panel.mesh.file = panel.bdf: panel.bdf:8: GRID: nan is not a number"),
    (GRID6, "GRID,6,,inf,400.0,0.0", "panel.mesh.file = panel.bdf: panel.bdf:8: GRID: inf is not a number"),
    (GRID6, "GRID,6,,x,400.0,0.0", "panel.mesh.file = panel.bdf: panel.bdf:8: GRID: x is not a number"),
    (GRID6, "GRID,5,,400.0,400.0,0.0", "panel.mesh.file = panel.bdf: node 5 appears twice"),
    (GRID6, "GRID,x,,400.0,400.0,0.0", "panel.mesh.file = panel.bdf: panel.bdf:8: GRID: x is not allowed; a number from 1 is needed"),
    (GRID6, "GRID,1_6,,400.0,400.0,0.0", "panel.mesh.file = panel.bdf: panel.bdf:8: GRID: 1_6 is not allowed; a number from 1 is needed"),
    (GRID6, "GRID,6,3,400.0,400.0,0.0", "panel.mesh.file = panel.bdf: panel.bdf:8: GRID: CP = 3 is not read; allowed is blank, the basic system"),
    (f"{GRID6}\n", "", "panel.mesh.file = panel.bdf: element 1: node 6 is missing"),
    (GRID6, f"{GRID6}\nGRID,99,,400.0,399.0,0.0\nCTRIA3,99,1,6,7,99", "panel.mesh.file = panel.bdf: elements 99 and 2 overlap@"),
    ("CTRIA3,6,1,7,8,12", "CTRIA3,6,1,7,8,8", "panel.mesh.file = panel.bdf: element 6: a node appears twice in it"),
    ("CTRIA3,6,1,7,8,12", "CTRIA3,6,1,7,8,12\nCTRIA3,77,1,8,7,12", "panel.mesh.file = panel.bdf: elements 6 and 77 overlap at@"),
    ("CTRIA3,6,1,7,8,12", "CTRIA3,5,1,7,8,12", "panel.mesh.file = panel.bdf: element 5 appears twice"),
    ("CTRIA3,6,1,7,8,12", "CTRIA3,6,1,7,8", "panel.mesh.file = panel.bdf: panel.bdf:20: CTRIA3: a blank is not allowed; a number from 1 is needed"),
    ("CQUAD4,1,1,1,2,6,5", "CQUAD4,1,1,1,6,2,5", "panel.mesh.file = panel.bdf: element 1: its corners do not form a convex quadrilateral"),
    ("CQUAD4,1,1,1,2,6,5", "CBEAM,1,1,1,2,6,5", "panel.mesh.file = panel.bdf: panel.bdf:15: card CBEAM is not read; allowed are GRID, CTRIA3, CTRIAR, @"),
    ("CQUAD4,1,1,1,2,6,5\nCQUAD4,2,2,2,3,7,6", "CBEAM,1,1,1,2,6,5\nCQUAD8,2,2,2,3,7,6", "panel.mesh.file = panel.bdf: panel.bdf:15: card CBEAM is not read; allowed are GRID, CTRIA3, CTRIAR, @", "panel.mesh.file = panel.bdf: panel.bdf:16: card CQUAD8 is not read; allowed are GRID, CTRIA3, CTRIAR, @"),
    ("ENDDATA", "GRID,21,,5000.0,0.0,0.0\nGRID,22,,5400.0,0.0,0.0\nGRID,23,,5000.0,400.0,0.0\nCTRIA3,21,1,21,22,23\nENDDATA", "panel.mesh.file = panel.bdf: the mesh has 2 pieces: no edges join element 21 to element 1; a panel is one piece"),
    ("ENDDATA", "GRID,21,,1600.0,800.0,0.0\nGRID,22,,1600.0,1200.0,0.0\nCTRIA3,21,1,12,21,22\nENDDATA", "panel.mesh.file = panel.bdf: the mesh has 2 pieces: no edges join element 21 to element 1; a panel is one piece"),
    ("ENDDATA", "GRID,21,,1200.0,800.0,0.0\nGRID,22,,1600.0,800.0,0.0\nGRID,23,,1600.0,1200.0,0.0\nCTRIA3,21,1,21,22,23\nENDDATA", "panel.mesh.file = panel.bdf: nodes 12 and 21 are at one place (1.2, 0.8) m: the panel is cracked there; merge them@"),
    (None, "", "panel.mesh.file = panel.bdf: no CTRIA3 or CQUAD4; a mesh needs one"),
    (None, "CTRIA3,1,1,1,2,3\n", "panel.mesh.file = panel.bdf: element 1: node 1 is missing"),
    (None, "GRID,1,,0.,0.,0.\n", "panel.mesh.file = panel.bdf: no CTRIA3 or CQUAD4; a mesh needs one"),
    (None, "+,1,2\n", "panel.mesh.file = panel.bdf: panel.bdf:1: a continuation without a card"),
    (None, b"\x7fELF\x00\x00", "panel.mesh.file = panel.bdf: panel.bdf:1: must be text; it has a byte 0x00, as of a binary file"),
    (None, "<html>\n", "panel.mesh.file = panel.bdf: panel.bdf:1: card <HTML> is not read; allowed are GRID, CTRIA3, CTRIAR, @"),
]  # fmt: skip
GMSH = [
    (None, "", "panel.mesh.file = panel.msh: not a gmsh mesh: it must begin with $MeshFormat"),
    (None, "not a mesh\n", "panel.mesh.file = panel.msh: not a gmsh mesh: it must begin with $MeshFormat"),
    (None, b"\x7fELF\x00\x00", "panel.mesh.file = panel.msh: not a gmsh mesh: it must begin with $MeshFormat"),
    (None, "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n", "panel.mesh.file = panel.msh: no triangles or quadrilaterals; a mesh needs them"),
    ("2.2 0 8", "9.9 0 8", "panel.mesh.file = panel.msh: not a gmsh mesh: Unknown MSH file version 9.9"),
    ("2 3 2 2 2 2 3 6 5", "2 3 2 2 2 2 3 6 9", "panel.mesh.file = panel.msh: not a gmsh mesh: Wrong node index 9"),
    ("2 3 2 2 2 2 3 6 5", "2 1 2 2 2 2 3", "panel.points.centre.grid = 3: no node 3; it has 4 nodes from 1 to 5"),
    ("2 3 2 2 2 2 3 6 5", "2 16 2 2 2 1 2 3 4 5 6 1 2", "panel.mesh.file = panel.msh: element 2 is a Quadrilateral 8; allowed are triangles and quadrilaterals of first order"),
    ("6 800 400 0", "6 nan 400 0", "panel.mesh.file = panel.msh: node 6: its position is not a number"),
    ("2 3 2 2 2 2 3 6 5", "2 2 2 2 2 2 3 6", "panel.mesh.file = panel.msh: the mesh has 2 pieces: no edges join element 2 to element 1; a panel is one piece"),
    ("6 800 400 0", "6 800 400 7", "panel.mesh.file = panel.msh: node 6: z = 0.007 m, most have 0 m; the panel must be plane, in x and y"),
]  # fmt: skip
FOR_GMSH = [
    ("panel.bdf", "panel.msh"),
    ("grid: 7", "grid: 3"),
    ("[1.2, 0.8]", "[0.8, 0.4]"),
    ("group: 2", "group: middle"),
]


def matches(told, expected):
    """Whether a line is what is expected: whole, or up to ``@``."""
    return told.startswith(expected[:-1]) if expected.endswith("@") else told == expected


def checked(place, folder, name, content, message):
    """Assert what is told of a study one of whose files has another content."""
    path = folder / name
    before = path.read_bytes()
    try:
        path.write_bytes(content if isinstance(content, bytes) else content.encode())
        told = [one.split(": ", 1)[1] for one in place.told()]
    finally:
        path.write_bytes(before)
    if message[-1] == "@@":  # at least these
        message = message[:-1]
        assert len(told) >= max(1, len(message))
        told = told[: len(message)]
    assert len(told) == len(message), told
    for line, expected in zip(told, message, strict=True):
        assert matches(line, expected), line
        assert "Traceback" not in line


CASES = [
    *(("thin", "spectrum.csv", *case) for case in SPECTRA),
    *(("sandwich", "lab.csv", *case) for case in TABLES),
    *(("shaker", "shaker.csv", *case) for case in SHAKERS),
    *(("sandwich", "tuned.csv", *case) for case in IMPEDANCES),
    *(("file", "panel.bdf", *case) for case in NASTRAN),
    *(("file", "panel.msh", *case) for case in GMSH),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[1]}: {case[3][:40]!r}")
def test_a_file_that_cannot_be_read_is_told_line_by_line(
    written, folder, bases, files, change, case
):
    # red: any one of the checks of columns, sound.table, damping.table_files, nastran, flat_mesh
    base, name, old, new, *message = case
    study = bases[base]
    if name.endswith(".msh"):
        for old_text, new_text in FOR_GMSH:
            study = change(study, old_text, new_text)
    content = new if old is None else change(files[name], old, new)
    checked(written(study), folder, name, content, message)


@pytest.mark.skipif(os.geteuid() == 0, reason="root may read every file")
def test_a_file_that_may_not_be_read_is_told(written, folder, bases):
    # red: OSError let through in read_text
    place = written(bases["thin"])
    (folder / "spectrum.csv").chmod(0)
    told = place.told()
    (folder / "spectrum.csv").chmod(0o644)
    assert told == [f"mine.yaml:30: {SPL}: cannot be read: Permission denied"]


def test_a_file_that_is_too_large_is_told(written, folder, bases):
    # red: no `limit` in read_text
    path = folder / "huge.csv"
    with path.open("wb") as file:
        file.truncate(30_000_000)
    (told,) = written(bases["thin"].replace("spectrum.csv", "huge.csv")).told()
    assert told.endswith("huge.csv: has 30 MB; allowed are 20 MB")


@pytest.mark.parametrize(
    ("name", "content"),
    [
        ("spectrum.csv", "spl_db,center_hz\n124,63\n126,80\n128,100\n130,125\n131,160\n131,200\n131,250\n130,315\n128,400\n"),
        ("spectrum.csv", b"\xef\xbb\xbfcenter_hz,spl_db\r\n63,124\r\n125,130\r\n250,131\r\n500,127\r\n"),
        ("spectrum.csv", " center_hz , spl_db # Hz, dB\n\n63, 124 # a band\n125,130\n250,131\n500,127\n\n"),
        ("spectrum.csv", '"center_hz","spl_db"\n63.1,124\n125.9,130\n251,131\n501,127'),
        ("spectrum.csv", "center_hz,spl_db\n63,1.24e2\n125,130\n250,131\n500,+127\n"),
    ],
)  # fmt: skip
def test_a_file_that_is_odd_and_right_is_read(written, folder, bases, files, name, content):
    # red: columns by their place; no strip of cells; decode("utf-8")
    path = folder / name
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    told = written(bases["thin"]).told()
    path.write_text(files[name])
    assert told == []


def test_the_meshes_of_the_corpus_are_read(written, bases, change):
    # red: a check of pieces that takes triangles for pieces
    study = bases["file"]
    assert written(study).told() == []
    for old, new in FOR_GMSH:
        study = change(study, old, new)
    assert written(study).told() == []
