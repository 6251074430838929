"""Results of one study are not overwritten by another of the same name."""

import shutil

import pytest

from pidpanel.cli import MISTAKE, main
from pidpanel.paths import STUDIES
from pidpanel.provenance.owner import MARK, OwnerError, check_owner, write_owner
from pidpanel.study import load_any_study

TEXT = (STUDIES / "l_panel.yaml").read_text()


@pytest.fixture
def home(tmp_path):
    """A folder with a study, the mark of its run, and the study's file."""
    folder = tmp_path / "home"
    return folder, _study(folder, TEXT)


def _study(folder, text, name="lp.yaml"):
    folder.mkdir(exist_ok=True)
    path = folder / name
    path.write_text(text)
    study = load_any_study(path)
    if not (folder / "results").exists():
        write_owner(study, path, folder / "results")
    return path


def _changed(text=TEXT):
    assert "damping_ratio: 0.01" in text
    return text.replace("damping_ratio: 0.01", "damping_ratio: 0.02")


def _check(file, results):
    check_owner(load_any_study(file), file, results)


def test_another_study_of_the_name_is_refused(home, tmp_path):
    # red: `return` at the top of check_owner
    folder, own = home
    other = _study(tmp_path / "other", _changed())
    with pytest.raises(OwnerError, match=f"results of {own}, another study named lp"):
        _check(other, folder / "results")


def test_a_study_of_the_name_that_has_a_mistake_now_still_owns_its_results(home, tmp_path):
    # red: False in place of True in _is_another
    folder, own = home
    own.write_text(TEXT.replace("damping_ratio: 0.01", "damping_ratio: -1"))
    with pytest.raises(OwnerError):
        _check(_study(tmp_path / "other", _changed()), folder / "results")


def test_the_same_study_goes_on(home, tmp_path):
    # red: `other.samefile(file)` left out (edited); `_said(...) != _said(study)` always true (copy)
    folder, own = home
    copy = _study(tmp_path / "copy", TEXT)
    _check(copy, folder / "results")
    own.write_text(_changed())
    _check(own, folder / "results")
    link = tmp_path / "lp.yaml"
    link.symlink_to(own)
    _check(link, folder / "results")


def test_a_study_that_is_not_there_any_more_holds_nothing(home, tmp_path):
    # red: `not other.is_file() or` left out raises
    folder, own = home
    other = _study(tmp_path / "other", _changed())
    own.rename(folder / "moved.yaml")
    _check(other, folder / "results")


def test_a_study_that_has_another_name_now_holds_nothing(home, tmp_path):
    # red: the comparison of the names left out of _is_another
    folder, own = home
    own.write_text(f"name: other\n{TEXT}")
    _check(_study(tmp_path / "other", _changed()), folder / "results")


def test_a_folder_that_was_copied_with_its_results_is_on_its_own(home, tmp_path):
    # red: `file.resolve()` in place of the relative path in write_owner
    folder, _ = home
    copied = tmp_path / "copied"
    shutil.copytree(folder, copied)
    (copied / "lp.yaml").write_text(_changed())
    _check(copied / "lp.yaml", copied / "results")


def test_results_that_two_folders_share_by_a_link_have_one_owner(home, tmp_path):
    # red: `results.absolute()` in place of `results.resolve()`
    folder, _ = home
    linked = tmp_path / "linked"
    linked.mkdir()
    (linked / "results").symlink_to(folder / "results")
    with pytest.raises(OwnerError):
        _check(_study(linked, _changed()), linked / "results")


@pytest.mark.parametrize("mark", [b"", b"\xff\xfe", b"a\0b", b"." * 5000])
def test_a_mark_that_says_nothing_holds_nothing(home, tmp_path, mark):
    # red: ValueError left out of what check_owner passes over
    folder, _ = home
    (folder / "results" / "lp" / MARK).write_bytes(mark)
    _check(_study(tmp_path / "other", _changed()), folder / "results")


@pytest.mark.parametrize("command", ["run", "status", "report", "export"])
def test_every_command_that_reads_or_writes_results_refuses_those_of_another(
    home, tmp_path, capsys, command
):
    # red: the call of check_owner left out of the command
    folder, _ = home
    other = _study(tmp_path / "other", _changed())
    assert main([command, str(other), "-d", str(folder)]) == MISTAKE
    said = capsys.readouterr().err
    assert said.count("\n") == 1 and "another study named lp" in said
