"""Inputs that are good number by number and cannot be meant: what an engineer confuses."""

import pytest

SPL = "sound.spectrum = spectrum.csv: spectrum.csv"
LAB = "dampers.lab.table = lab.csv"
LEAVE_OUT = (
    "; omit the row of the overall level; oaspl_db of the section sound shifts to an overall level"
)

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
    ("file", "panel.bdf", lambda text: text.replace("CQUAD4,3,1,3,4,8,7", "CQUAD4,3,1,13,4,8,14").replace("ENDDATA", "GRID,13,,800.0,0.0,0.0\nGRID,14,,800.0,400.0,0.0\nENDDATA"), "panel.mesh.file = panel.bdf: nodes 3 and 13 are at one place (0.8, 0) m: the panel is cracked there; merge them"),
    ("file", "panel.bdf", lambda text: text.replace("GRID,6,,400", "GRID,6,3,400"), "panel.mesh.file = panel.bdf: panel.bdf:8: GRID: CP = 3 is not read; allowed is blank, the basic system"),
    ("file", "panel.bdf", lambda text: text.replace("400.0,400.0,0.0", "400,0,400,0,0,0"), "panel.mesh.file = panel.bdf: node 6: z = 0.4 m, most have 0 m; the panel must be plane, in x and y"),
    ("file", "panel.bdf", lambda _: "1    MSC NASTRAN  JOB\n", "panel.mesh.file = panel.bdf: panel.bdf:1: card 1    MSC is not read; allowed are GRID, CTRIA3, @"),
]  # fmt: skip


def compare(told, message):
    """Assert what is told after file and line: whole, or up to ``@``."""
    assert len(told) == len(message), told
    for line, expected in zip(told, message, strict=True):
        said = line.split(": ", 1)[1]
        assert said.startswith(expected[:-1]) if expected.endswith("@") else said == expected


@pytest.mark.parametrize("case", FILES, ids=lambda case: f"{case[1]}: {case[3][-40:]!r}")
def test_what_an_engineer_confuses_in_a_file_is_told(written, folder, bases, files, case):
    # red: _overall_hints without its condition; `_told_once` that returns all
    base, name, content, *message = case
    path = folder / name
    try:
        path.write_text(content(files[name]), encoding="utf-8")
        told = written(bases[base]).told()
    finally:
        path.write_text(files[name], encoding="utf-8")
    compare(told, message)


def test_mistakes_between_sections_are_told_where_there_are_none_within(written, bases, change):
    # red: `mistakes_of_scenarios` that stops at its first mistake
    study = change(bases["sandwich"], "damper: lab", "damper: Lab")
    study = change(study, "slanted: {damper: foil}", "slantd: {damper: foil}")
    assert [one.split(": ")[1].split(" = ")[0] for one in written(study).told()] == [
        "scenarios.fill.damper",
        "scenarios.both.layout.slantd",
    ]
    study = change(study, "damping_ratio: 0.01", "damping_ratio: 1")
    study = change(study, "loss_factor: 0.1", "loss_factor: 10")
    assert [one.split(": ")[1].split(" = ")[0] for one in written(study).told()] == [
        "panel.damping_ratio",
        "dampers.layer.loss_factor",
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


def test_the_fills_of_a_table_are_compared(written, bases, change):
    # red: no _check_range
    study = change(bases["sandwich"], "[0.4, 0.8]\n  both", "[0.4, 0.95]\n  both")
    (told,) = written(study).told()
    assert told.split(": ")[1].startswith("scenarios.fill.fill_fraction[1]")


def test_a_section_that_is_missing_brings_no_mistakes_of_others(written, bases, change):
    # red: a check of what is not there
    told = written(change(bases["thin"], "panel:\n", "panl:\n")).told()
    assert [one.split(": ", 1)[1].partition(" = ")[0] for one in told] == ["panel: missing", "panl"]
