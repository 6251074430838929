"""A deck of somebody else moves spheres and writes its rows, and does nothing else."""

import shutil

import pytest
from hypothesis import given
from hypothesis import strategies as st

from pidpanel.check import checked_study
from pidpanel.cli import main
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.liggghts import deck, trust
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


@pytest.fixture()
def study(tmp_path):
    """(text) → a study with the shake deck of the laboratory and that text at its end."""

    def write(text=""):
        own = (TEMPLATES / "shake_lab.in.j2").read_text() + text
        (tmp_path / "own.in.j2").write_text(own)
        (tmp_path / "own.yaml").write_text(STUDY)
        return tmp_path / "own.yaml"

    return write


@pytest.mark.parametrize("name", ["shake.in.j2", "shake_lab.in.j2"])
def test_our_own_decks_do_nothing_that_is_refused(name, study):
    # red: a command of theirs left out of `COMMANDS`
    run = cases_of(checked_study(study()).coupon)[0].runs[0]
    for restart in (None, "at_20.restart"):
        values = run.deck_values(restart=restart)
        text = deck.render(name, values)
        assert list(trust.refusals(text, deck.files_in(values))) == []


REFUSED = [
    ("shell touch hit", "the command shell"),
    ("she&\nll touch hit", "the command shell"),
    ("python f invoke", "the command python"),
    ("include other.in", "the command include"),
    ("jump other.in", "the command jump"),
    ("log /tmp/log", "the command log"),
    ("if 1 then 'shell touch hit'", "the command if"),
    ("run 100 every 10 'shell touch hit'", "run with more"),
    ("dump d all custom 1 '|touch hit' id", "the command dump"),
    ("write_restart ../x", "the command write_restart"),
    ("variable v getenv HOME", "a variable of the style getenv"),
    ("variable v string shell\n${v} touch hit", "a variable of the style string"),
    ("${v} touch hit", "the character $ is"),
    ("read_data '/etc/passwd'", "the file '/etc/passwd'"),
    ("read_data x;touch.gz", "the file 'x;touch.gz'"),
    ("fix f all ave/time 1 1 1 v_p file ../rows.txt", "the file '../rows.txt'"),
    ("fix f all ave/time 1 1 1 v_p file", "the file ''"),
    ("fix f all imd 1234", "the fix imd"),
    ("fix f all print 10 x file /tmp/x", "the fix print"),
    ("fix s all mesh/surface file /etc/passwd type 2", "the file '/etc/passwd'"),
    ("'shell' touch hit", "a quote at the beginning"),
    ("timestep 1\rshell touch hit", "the character '\\r'"),
    ("timestep 1\x00", "the character '\\x00'"),
    ('print "no end', "a quote that is not closed"),
]  # fmt: skip


@pytest.mark.parametrize(("text", "message"), REFUSED)
def test_what_a_deck_must_not_do_is_refused_before_anything_runs(study, text, message):
    # red: each name put into its list; the line joined with a blank; `"$" in line` left out
    run = cases_of(checked_study(study()).coupon)[0].runs[0]
    files = deck.files_in(run.deck_values())
    said = list(trust.refusals(f"timestep 1e-6\n{text}\n", files))
    assert said and message in said[0], said


def test_a_refused_deck_is_one_line_of_the_check_unless_it_is_trusted(study, capsys, monkeypatch):
    # red: `deck_text` without `refusals`; the variable not set by --trust-deck
    monkeypatch.setenv(trust.TRUST, "")
    path = study("shell touch hit\n")
    with pytest.raises(
        StudyError, match=r"own\.yaml:6: coupon\.deck = .*the command shell"
    ) as told:
        checked_study(path)
    assert len(str(told.value).splitlines()) == 1
    assert main(["check", str(path)]) == 2
    assert "--trust-deck" in capsys.readouterr().err
    assert main(["check", "--trust-deck", str(path)]) == 0
    run = cases_of(checked_study(path).coupon)[0].runs[0]
    monkeypatch.setenv(trust.TRUST, "0")  # what was planned is not what is run
    with pytest.raises(DeckRefused, match="the command shell"):
        run.deck_text()


@pytest.mark.parametrize(
    "text",
    [
        "{{ depth.__class__.__mro__ }}",
        "{{ ''.__class__.__base__.__subclasses__() }}",
        "{% for k in cells.__class__.mro() %}{% endfor %}",
        "{{ 'x' * 10**9 }}",
        "{{ 9**(9**9) }}",
        "{{ range(10**9)|list }}",
        "{{ 1/0 }}",
        "{% include '../secret' %}",
        "{% include 'nowhere' %}",
    ],
)
def test_a_template_reaches_its_values_and_nothing_behind_them(study, text):
    # red: `jinja2.Environment` for the sandbox; its `call_binop` left out (a gigabyte of text)
    path = study(f"# {text}\n")
    (path.parent.parent / "secret").write_text("secret")
    with pytest.raises(StudyError, match=r"coupon\.deck") as told:
        checked_study(path)
    assert len(str(told.value).splitlines()) == 1


@given(st.text(alphabet=st.sampled_from("shel& \n\t#'\"$xfile/.{}") | st.characters(), max_size=60))
def test_whatever_a_deck_holds_it_is_refused_or_holds_only_known_commands(text):
    # red: `ValueError` of shlex let through
    if not list(trust.refusals(text, ())):
        for line in deck.without_comments(text.replace("&\n", "")).splitlines():
            assert line.split()[0] in trust.COMMANDS


def test_a_deck_that_came_with_pidpanel_is_trusted_and_a_copy_is_not(tmp_path, monkeypatch):
    # red: `is_relative_to` of the path as it is written
    monkeypatch.delenv(trust.TRUST, raising=False)
    shutil.copy(TEMPLATES / "shake_lab.in.j2", tmp_path)
    assert trust.is_trusted(TEMPLATES / "shake_lab.in.j2")
    assert not trust.is_trusted(tmp_path / "shake_lab.in.j2")
    assert not trust.is_trusted(TEMPLATES / ".." / tmp_path.name / "shake_lab.in.j2")
