"""A result is stamped with what its study says, wherever the study is."""

import shutil
from pathlib import Path

import pytest
import yaml

from pidpanel.provenance import digests
from pidpanel.provenance.digests import stamp
from pidpanel.study import load_any_study

STUDIES = Path(__file__).parents[2] / "workflow" / "studies"
SPECTRUM = "center_hz,spl_db\n100,120\n200,121\n"


def study_in(folder, **changes):
    """A study with a spectrum, a mesh and decks of its own, in a folder."""
    folder.mkdir()
    values = yaml.safe_load((STUDIES / "bdf_panel.yaml").read_text())
    sweep = {"frequency_hz": [100], "acceleration_g": [10]}
    values["dampers"] = {"own": {"particles": {}, "sweep": sweep, "deck": "own.in.j2"}}
    values["sound"]["spectrum"] = "spectrum.csv"
    values |= {"name": "mine"} | changes
    (folder / "mine.yaml").write_text(yaml.safe_dump(values, sort_keys=False))
    (folder / "spectrum.csv").write_text(SPECTRUM)
    (folder / "own.in.j2").write_text("run {{ steps_per_cycle }}")
    shutil.copy(STUDIES / "bdf_panel.bdf", folder)
    return folder


def hash_of(folder):
    return stamp(load_any_study(folder / "mine.yaml"))["study_hash"]


def test_copies_of_a_study_in_two_folders_have_one_hash(tmp_path):
    assert hash_of(study_in(tmp_path / "one")) == hash_of(study_in(tmp_path / "two"))


@pytest.mark.parametrize("name", ["spectrum.csv", "own.in.j2", "bdf_panel.bdf"])
def test_the_hash_changes_with_the_content_of_a_file_that_is_named(tmp_path, name):
    folder = study_in(tmp_path / "one")
    before = hash_of(folder)
    with (folder / name).open("a") as file:
        file.write("\n")
    assert hash_of(folder) != before


def test_the_hash_changes_with_a_varied_deck(tmp_path):
    sweep = {"frequency_hz": [100], "acceleration_g": [10]}
    coupon = {"sweep": sweep, "vary": {"deck": ["own.in.j2", None]}}
    folder = tmp_path / "one"
    study_in(folder)
    (folder / "mine.yaml").write_text(yaml.safe_dump({"coupon": coupon}))
    before = hash_of(folder)
    (folder / "own.in.j2").write_text("run 2")
    assert hash_of(folder) != before


def test_the_hash_changes_with_a_value_and_with_the_order_of_families(tmp_path):
    families = {
        "one": {"patch": "side", "fill_fraction": [0.5]},
        "two": {"patch": ["side"], "fill_fraction": 0.5},
    }
    hashes = {
        hash_of(study_in(tmp_path / "one")),
        hash_of(study_in(tmp_path / "two", title="another")),
        hash_of(study_in(tmp_path / "three", scenarios=families)),
        hash_of(study_in(tmp_path / "four", scenarios=dict(reversed(families.items())))),
    }
    assert len(hashes) == 4


def test_a_stamp_has_no_time_and_five_keys(tmp_path):
    said = stamp(load_any_study(study_in(tmp_path / "one") / "mine.yaml"))
    versions = {"pidpanel_version", "liggghts_version"}
    assert set(said) == {"study", "study_hash", "Conventions", *versions}
    assert said["Conventions"].startswith("CF-1.")
    assert said["study"] == "mine"
    assert len(said["study_hash"]) == 16


def test_files_count_by_their_content_and_order(tmp_path):
    one, two, same = (tmp_path / name for name in ("one", "two", "same"))
    one.write_text("1")
    two.write_text("2")
    same.write_text("1")
    assert digests.file_digest(one) == digests.file_digest(same)
    assert digests.file_digest(one, two) != digests.file_digest(two, one)
    assert digests.text_digest(["a", "b"]) != digests.text_digest(["ab"])


@pytest.mark.parametrize(
    "file",
    [
        "pidpanel/panel/plate.py",
        "pidpanel/base/variables.csv",
        "workflow/scripts/panel.py",
        "templates/a.j2",
        "data/b.csv",
    ],
)
def test_the_digest_of_the_package_follows_its_files_and_not_where_they_are(
    tmp_path, monkeypatch, file
):
    found = []
    for name, text in (("one", "1"), ("two", "1"), ("three", "2")):
        root = tmp_path / name
        for path in (
            "pidpanel/panel/plate.py",
            "pidpanel/base/variables.csv",
            "workflow/scripts/panel.py",
            "templates/a.j2",
            "data/b.csv",
        ):
            (root / path).parent.mkdir(parents=True)
            (root / path).write_text(text if path == file else "")
        for key, folder in (
            ("PACKAGE", "pidpanel"),
            ("WORKFLOW", "workflow"),
            ("TEMPLATES", "templates"),
            ("DATA", "data"),
        ):
            monkeypatch.setattr(digests, key, root / folder)
        found.append(digests.package_digest.__wrapped__())
    assert found[0] == found[1] != found[2]
