"""Tables and meshes that cannot be read are told at the key that names them, with line and column."""

import pytest

OCTAVES = "center_hz,spl_db\n63,124\n125,130\n250,131\n500,127\n"
# base → the file that is changed, and the key that names it
FILES = {
    "thin": ("spectrum.csv", "sound.spectrum"),
    "sandwich": ("lab.csv", "dampers.lab.table"),
    "shaker": ("shaker.csv", "base.random.spectrum"),
    "file": ("panel.bdf", "panel.mesh.file"),
}
ROW = "0.4,100,1,820,5.1"
GRID = "GRID,6,,400.0,400.0,0.0"
QUAD = "CQUAD4,1,1,1,2,6,5"
# (base, what is there or "" for all, what is written instead, place and cause of each mistake)
CASES = [
    ("thin", "center_hz,spl_db", "when,loud", "line 2: column 'when'", "line 2: column 'loud'"),
    ("thin", "63,124", "63,632", "line 3: spl_db = 632"),
    ("thin", "63,124", "63,", "line 3: spl_db = (empty)"),
    ("thin", "63,124", "63,124,5", "line 3: has 3 values"),
    ("thin", "63,124\n80,126", "66,124\n80,x", "line 3: center_hz = 66", "line 4: spl_db = 'x'"),
    ("thin", "100,128\n", "100,128\n80,126\n", "line 6: center_hz = 80"),
    ("thin", "125,130\n", "", "line 6: between 100 and 160 Hz there is a gap"),
    ("thin", "", " ", "empty"),
    ("thin", "", "center_hz,spl_db\n125,130\n", "1 band"),
    ("thin", "", "center_hz,spl_db\n63,1.2\n125,8.1\n250,9.7\n500,3.1\n", "bands sum to"),
    ("thin", "", "frequency_hz,psd_pa2_hz\n60,20\n500,-3\n", "line 3: psd_pa2_hz = -3"),
    ("thin", "", OCTAVES + "OASPL,137.5\n", "line 6: states 137.5 dB"),
    ("sandwich", "acceleration_g", "acceleration_m_s2", "line 2: column 'acceleration_m_s2'"),
    ("sandwich", "fill_fraction,", "frequency_hz,", "line 2: column frequency_hz: given twice"),
    ("sandwich", ROW, "40,100,1,820,5.1", "line 3: fill_fraction = 40"),
    ("sandwich", ROW, "0.4,100,1,5e7,5.1", "line 3: equivalent_damping_n_s_m3 = 5e+07"),
    ("sandwich", ROW, "0,4,100,1,820,5,1", "line 3: has 7 values, must have 5 as the header (decimal commas?)"),
    ("sandwich", "0.4,400,1,1450,4.6", "0.4,100,1,1450,4.6", "line 4: fill_fraction = 0.4, frequency_hz = 100, acceleration_g = 1: duplicate"),
    ("sandwich", ROW, "0.4,100,1,820,5100", "line 3: apparent_mass_kg_m2 = 5100"),
    ("shaker", "80,0.04,0\n300", "300,0.04,0\n80", "line 5: frequency_hz = 80 follows 300"),
    ("shaker", "20,0.01,3\n80,0.04,0", "20,0.01,\n80,,", "line 4: a gap"),
    ("shaker", "20,0.01,3", "20,0.01,-3", "line 3: slope_db_octave = -3"),
    ("file", GRID, "GRID,6,,400.0,400.0,5.0", "node 6: z = 0.005 m"),
    ("file", GRID, "GRID,6,,nan,400.0,0.0", "panel.bdf:8: GRID: nan"),
    ("file", GRID, "GRID,5,,400.0,400.0,0.0", "node 5 appears twice"),
    ("file", GRID, "GRID,6,3,400.0,400.0,0.0", "panel.bdf:8: GRID: CP = 3"),
    ("file", f"{GRID}\n", "", "element 1: node 6 is missing"),
    ("file", QUAD, "CQUAD4,1,1,1,6,2,5", "element 1: its corners"),
    ("file", QUAD, "CBEAM,1,1,1,2,6,5", "panel.bdf:15: card CBEAM"),
    ("file", "CTRIA3,6,1,7,8,12", "CTRIA3,5,1,7,8,12", "element 5 appears twice"),
    ("file", "ENDDATA", "GRID,21,,1600.0,800.0,0.0\nGRID,22,,1600.0,1200.0,0.0\nCTRIA3,21,1,12,21,22\nENDDATA", "the mesh has 2 pieces"),
    ("file", "", "GRID,1,,0.,0.,0.\n", "no CTRIA3 or CQUAD4"),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[0]}: {case[2][:40]!r}")
def test_a_file_that_cannot_be_read_is_told_line_by_line(
    written, folder, bases, files, change, case
):
    base, old, new, *causes = case
    name, key = FILES[base]
    try:
        (folder / name).write_text(change(files[name], old, new) if old else new, encoding="utf-8")
        told = [line.split(": ", 1)[1] for line in written(bases[base]).told()]
    finally:
        (folder / name).write_text(files[name], encoding="utf-8")
    assert len(told) == len(causes), told
    for line, cause in zip(told, causes, strict=True):
        assert line.startswith(f"{key} = {name}: ") and cause in line


def test_a_file_that_is_too_large_is_told(written, folder, bases):
    with (folder / "huge.csv").open("wb") as file:
        file.truncate(30_000_000)
    (told,) = written(bases["thin"].replace("spectrum.csv", "huge.csv")).told()
    assert told.endswith("huge.csv: has 30 MB; allowed are 20 MB")


@pytest.mark.parametrize("content", [
    "spl_db,center_hz\n124,63\n130,125\n131,250\n127,500\n",
    b"\xef\xbb\xbf" + OCTAVES.replace("\n", "\r\n").encode(),
    " center_hz , spl_db # Hz, dB\n\n63, 1.24e2 # a band\n125,+130\n250,131\n500,127\n\n",
])  # fmt: skip
def test_a_file_that_is_odd_and_right_is_read(written, folder, bases, files, content):
    path = folder / "spectrum.csv"
    path.write_bytes(content if isinstance(content, bytes) else content.encode())
    told = written(bases["thin"]).told()
    path.write_text(files["spectrum.csv"])
    assert told == []


def test_meshes_of_nastran_and_gmsh_are_read(written, bases, change):
    study = bases["file"]
    assert written(study).told() == []
    for old, new in (("panel.bdf", "panel.msh"), ("grid: 7", "grid: 3"),
                     ("[1.2, 0.8]", "[0.8, 0.4]"), ("group: 2", "group: middle")):  # fmt: skip
        study = change(study, old, new)
    assert written(study).told() == []
