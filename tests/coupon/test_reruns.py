"""What makes a packing, a bed or a run another one, and what does not: docs/reruns.md."""

import dataclasses
import shutil

import pytest

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.coupon import bed as bed_module
from pidpanel.coupon import packing as packing_module
from pidpanel.coupon.drive import Tone
from pidpanel.coupon.from_study import cases_of
from pidpanel.coupon.liggghts import deck, process
from pidpanel.coupon.liggghts.deck import TRUST
from pidpanel.paths import TEMPLATES
from pidpanel.study.coupon import Coupon

SWEEP = {"fill_fraction": [0.5], "frequency_hz": [100], "acceleration_g": [20]}


def identities(**changes):
    """Hashes of the packing, the bed and the run of a coupon."""
    coupon = Coupon.model_validate({"cell": {"count": 1}, "sweep": SWEEP} | changes)
    run = cases_of(coupon)[0].point
    return run.packing.identity, run.bed.identity, run.identity


def changed(before, **changes):
    """Which of the three are others than before."""
    kinds = ("packing", "bed", "run")
    after = identities(**changes)
    return [kind for kind, a, b in zip(kinds, before, after, strict=True) if a != b]


ALL = ["packing", "bed", "run"]


# ------------------------------------------------------------------ templates


@pytest.fixture
def templates(tmp_path, monkeypatch):
    """A copy of the templates that may be changed before anything is rendered."""
    folder = tmp_path / "templates"
    shutil.copytree(TEMPLATES, folder)
    environment = deck._environment.__wrapped__
    monkeypatch.setattr(deck, "_environment", lambda _: environment(folder))
    new_process()
    yield folder
    new_process()


def new_process():
    """Forget what is computed once in a process."""
    deck.digest.cache_clear()


def edit(path, old, new):
    text = path.read_text()
    assert old in text
    path.write_text(text.replace(old, new, 1))
    new_process()


COMMENTED = ("header.j2", "contacts.j2", "fill.in.j2", "shake.in.j2")


@pytest.mark.parametrize("name", COMMENTED)
def test_a_comment_in_a_template_leaves_every_run_as_it_is(templates, name):
    before = identities()
    path = templates / name
    lines = path.read_text().splitlines()
    last = next(i for i in reversed(range(len(lines))) if not lines[i].startswith("{%"))
    lines[last] += "   # said at the end of a line"
    new_process()
    path.write_text("# said\n{# or in Jinja #}\n\n" + "\n".join(lines) + "\n\n  # at the end\n")
    assert changed(before) == []


@pytest.mark.parametrize(
    ("name", "old", "new", "others"),
    [
        ("fill.in.j2", "fix move all nve/sphere", "fix move all nve/sphere disc", ALL),
        ("header.j2", "hard_particles yes", "hard_particles no", ALL),
        ("contacts.j2", "pair_coeff * *", "pair_coeff 1 1", ALL),
        ("shake.in.j2", "fix move all nve/sphere", "fix move all nve/sphere disc", ["bed", "run"]),
        # only a run continues from a restart
        ("header.j2", "read_restart {{ restart_file }}", "read_restart {{ restart_file }} remap", ["run"]),
    ],
)  # fmt: skip
def test_a_command_in_a_template_makes_anew_what_is_run_with_it(templates, name, old, new, others):
    before = identities()
    edit(templates / name, old, new)
    assert changed(before) == others


def test_a_deck_of_the_users_own_enters_with_what_it_includes_and_not_with_its_place(
    tmp_path, monkeypatch
):
    monkeypatch.setenv(TRUST, "1")
    here, there = tmp_path / "here", tmp_path / "there"
    for folder in (here, there):
        folder.mkdir()
        (folder / "own.in.j2").write_text('{% include "extra.j2" %}\n{% include "header.j2" %}\n')
        (folder / "extra.j2").write_text("units si\n")
    before = identities(deck=here / "own.in.j2")
    assert changed(identities(), deck=here / "own.in.j2") == ["run"]
    assert changed(before, deck=there / "own.in.j2") == []
    (there / "extra.j2").write_text("units cgs\n")
    new_process()
    assert changed(before, deck=there / "own.in.j2") == ["run"]


def test_a_comment_ends_where_the_line_does_and_is_none_in_quotes():
    text = "run 10  # ten\n\n  # nothing\nprint 'a # b'   &\n\tx\n"
    assert deck.without_comments(text) == "run 10\nprint 'a # b' &\nx"


# ------------------------------------------------------------------ constants, version


@pytest.mark.parametrize(
    "field", [field.name for field in dataclasses.fields(packing_module.Pouring)]
)
def test_every_constant_of_the_pour_makes_new_packings(monkeypatch, field):
    before = identities()
    other = {field: 1.1 * getattr(packing_module.POURING, field)}
    monkeypatch.setattr(
        packing_module, "POURING", dataclasses.replace(packing_module.POURING, **other)
    )
    assert changed(before) == ALL


@pytest.mark.parametrize(
    "other",
    [
        {"drive": Tone(120.0, 10 * STANDARD_GRAVITY)},
        {"cycles": 21},
        {"frames": 10},
        {"time_step_rayleigh": 0.1},
        {"samples_per_cycle": 50},
    ],
)
def test_every_constant_of_the_loosening_makes_new_beds_of_the_same_packings(monkeypatch, other):
    before = identities()
    monkeypatch.setattr(bed_module, "LOOSENING", dataclasses.replace(bed_module.LOOSENING, **other))
    assert changed(before) == ["bed", "run"]


def test_another_liggghts_makes_everything_anew(monkeypatch):
    before = identities()
    monkeypatch.setattr(process, "VERSION", "3.9.0")
    assert changed(before) == ALL


def test_what_only_the_bed_or_the_run_depends_on_leaves_the_packing():
    before = identities()
    assert changed(before, sweep=SWEEP | {"fill_fraction": [0.6]}) == ["bed", "run"]
    assert changed(before, gravity_g=0.5) == ["bed", "run"]
    assert changed(before, particles={"restitution": 0.7}) == ["bed", "run"]
    assert changed(before, sweep=SWEEP | {"acceleration_g": [21]}) == ["run"]
    assert changed(before, time_step_rayleigh=0.1) == ["run"]
    assert changed(before, accuracy={"relative_error": 0.01}) == []
    assert changed(before, particles={"friction": 0.31}) == ALL


# ------------------------------------------------------------------ algorithms


@pytest.mark.parametrize(
    ("module", "name", "others"),
    [
        (packing_module, "PLACEMENT_VERSION", ALL),
        (packing_module, "POUR_VERSION", ALL),
        (bed_module, "LOOSEN_VERSION", ["bed", "run"]),
    ],
)
def test_another_version_of_an_algorithm_makes_anew_what_it_made(monkeypatch, module, name, others):
    before = identities()
    monkeypatch.setattr(module, name, getattr(module, name) + 1)
    assert changed(before) == others
