"""A deck of somebody else is a program: nothing of it is rendered or run before it is trusted."""

import shutil

import pytest

from pidpanel.check import checked_study
from pidpanel.cli import main
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.liggghts import deck
from pidpanel.coupon.liggghts.failures import DeckRefused
from pidpanel.paths import TEMPLATES
from pidpanel.study import StudyError

STUDY = """\
title: "A deck of one's own"
coupon:
  cell: {shape: hexagon, across_flats_mm: 6.35, depth_mm: 10, count: 1}
  particles: {diameter_mm: 2.5, youngs_modulus_mpa: 50}
  sweep: {fill_fraction: [0.5], frequency_hz: [200], acceleration_g: [10]}
  deck: own.in.j2
"""
PROGRAMS = [
    "",
    'fix t all ave/time 1 1 1 v_p title2 a"#"b file /tmp/hit',  # passed a list of harmless commands
    'fix t all ave/time 1 1 1 v_p fi"le" /tmp/hit',
    "shell touch hit",
    "{{ ''.__class__.__base__.__subclasses__() }}",
    "{% include '../secret' %}",
    "{% for a in range(10**9) %}{% for b in range(10**9) %}{% endfor %}{% endfor %}",
]


@pytest.fixture()
def study(tmp_path, monkeypatch):
    """(text) → a study with the shake deck of the laboratory and that text at its end."""
    monkeypatch.delenv(deck.TRUST, raising=False)

    def write(text=""):
        own = (TEMPLATES / "shake_lab.in.j2").read_text() + text
        (tmp_path / "own.in.j2").write_text(own)
        (tmp_path / "own.yaml").write_text(STUDY)
        return tmp_path / "own.yaml"

    return write


def test_a_link_to_a_deck_of_ours_includes_nothing_that_lies_next_to_it(study, tmp_path):
    path = study()
    hit = tmp_path / "hit"
    program = f"{{{{ cycler.__init__.__globals__.os.system('touch {hit}') }}}}"
    for name in ("header.j2", "contacts.j2"):
        (tmp_path / name).write_text(program)
    (tmp_path / "own.in.j2").unlink()
    (tmp_path / "own.in.j2").symlink_to(TEMPLATES / "shake_lab.in.j2")
    run = cases_of(checked_study(path).coupon)[0].runs[0]
    assert "pair_style gran" in run.deck_text()
    assert not hit.exists()


@pytest.mark.parametrize("name", ["header.j2", "../own.in.j2", "SHAKE.in.j2", "results/x/shake.in"])
def test_a_hard_link_and_a_deck_elsewhere_are_the_user_s(study, tmp_path, name):
    folder = tmp_path / "folder"
    (folder / "results" / "x").mkdir(parents=True)
    path = study().rename(folder / "own.yaml")
    if not (folder / name).exists():
        (folder / name).hardlink_to(tmp_path / "own.in.j2")
    path.write_text(STUDY.replace("own.in.j2", name))
    with pytest.raises(StudyError, match="a program"):
        checked_study(path)


@pytest.mark.parametrize("text", PROGRAMS)
def test_no_deck_of_the_user_is_read_before_it_is_trusted(study, text, capsys):
    path = study(f"{text}\n")
    with pytest.raises(StudyError, match=r"own\.yaml:6: coupon\.deck = .*a program") as told:
        checked_study(path)
    assert len(str(told.value).splitlines()) == 1
    assert main(["check", str(path)]) == 2
    assert "--trust-deck" in capsys.readouterr().err


def test_a_deck_that_is_trusted_is_checked_and_run(study, monkeypatch):
    monkeypatch.setenv(deck.TRUST, "")
    path = study()
    assert main(["check", "--trust-deck", str(path)]) == 0
    run = cases_of(checked_study(path).coupon)[0].runs[0]
    assert "seen from the laboratory" in run.deck_text()
    monkeypatch.setenv(deck.TRUST, "0")  # what was planned is not what is run
    for asked in (run.deck_text, run.deck_digest, lambda: run.lists_contacts):
        with pytest.raises(DeckRefused, match="a program"):
            asked()


def test_a_deck_that_came_with_pidpanel_is_trusted_and_a_copy_is_not(tmp_path, monkeypatch):
    monkeypatch.delenv(deck.TRUST, raising=False)
    shutil.copy(TEMPLATES / "shake_lab.in.j2", tmp_path)
    deck.check_trust(TEMPLATES / "shake_lab.in.j2")
    for path in (tmp_path, TEMPLATES / ".." / tmp_path.name):
        with pytest.raises(DeckRefused):
            deck.check_trust(path / "shake_lab.in.j2")
