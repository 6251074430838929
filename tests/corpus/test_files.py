"""Files that cannot be read are told at the key that names them, with line and column."""

import pytest

from pidpanel.check import checked_study
from pidpanel.paths import DATA, STUDIES
from tests.corpus.test_wrong import changed, refused, written

SPECTRUM = DATA / "spl" / "smc_s_016_2014_min_third.csv"
TABLE = "fill_fraction,frequency_hz,equivalent_damping_n_s_m3\n0.4,100,820\n0.4,400,900\n0.8,100,950\n0.8,400,990\n"
# (study, key of the file, its content, what is there, what is written instead, causes)
CASES = [
    ("smoke", "sound.spectrum", SPECTRUM.read_text(), "\n80,", "\n80,x", ["spl_db = 'x"]),
    ("smoke", "sound.spectrum", "center_hz,spl_db\n80,124\n100,126\n", "center_hz,spl_db", "when,loud",
     ["line 1: column 'when'", "line 1: column 'loud'"]),
    ("smoke", "sound.spectrum", " ", "", "", ["empty"]),
    ("smoke", "sound.spectrum", "center_hz,spl_db\n63,1.2\n125,8.1\n250,9.7\n500,3.1\n", "", "", ["bands sum to"]),
    ("smoke", "dampers.paper.table", TABLE, "0.4,100", "40,100", ["line 2: fill_fraction = 40"]),
    ("smoke", "dampers.paper.table", TABLE, "0.4,400", "0.4,100", ["line 3: fill_fraction = 0.4, frequency_hz = 100: duplicate"]),
    ("shaker", "base.random.spectrum", "frequency_hz,acceleration_psd_g2_hz\n20,1\n300,1\n80,1\n", "", "", ["line 4: frequency_hz = 80 follows 300"]),
    ("bdf_panel", "panel.mesh.file", (STUDIES / "bdf_panel.bdf").read_text(), "\nGRID", "\nCBEAM,9,1,1,2\nGRID", ["card CBEAM is not read"]),
]  # fmt: skip


@pytest.mark.parametrize("case", CASES, ids=lambda case: f"{case[1]}: {case[5][0]}")
def test_a_file_that_cannot_be_read_is_told_line_by_line(tmp_path, case):
    name, key, content, old, new, causes = case
    assert old in content
    file = tmp_path / ("file.bdf" if key.endswith("file") else "file.csv")
    file.write_text(content.replace(old, new, 1) if old else content, encoding="utf-8")
    study = changed(name, key, file.name)
    if "table" in key:
        study["dampers"]["paper"].pop("law")
    told, _ = refused(tmp_path, study)
    told = [text.split(": ", 1)[1] for text in told]
    assert len(told) == len(causes), told
    for text, cause in zip(told, causes, strict=True):
        assert text.startswith(f"{key} = {file.name}: ") and cause in text


def test_a_file_that_is_too_large_is_told(tmp_path):
    with (tmp_path / "huge.csv").open("wb") as file:
        file.truncate(30_000_000)
    (told,), _ = refused(tmp_path, changed("smoke", "sound.spectrum", "huge.csv"))
    assert told.endswith("huge.csv: has 30 MB; allowed are 20 MB")


@pytest.mark.parametrize("prefix", [b"", b"\xef\xbb\xbf"])
def test_a_file_that_is_odd_and_right_is_read(tmp_path, prefix):
    text = SPECTRUM.read_text().replace("\n", "\r\n").replace(",", " , ")
    (tmp_path / "odd.csv").write_bytes(prefix + text.encode())
    checked_study(written(tmp_path, changed("shaker", "sound", {"spectrum": "odd.csv"})).path)
