"""One damper of a study: one kind, the keys that belong to it, and what it takes of another."""

import pytest
import yaml
from pydantic import TypeAdapter, ValidationError

from pidpanel.paths import STUDIES
from pidpanel.study import load_study
from pidpanel.study.dampers import STATED, AnyDamper, BedDamper
from pidpanel.study.mistakes import mistakes_of
from pidpanel.study.stated_dampers import TableDamper

C, M = "equivalent_damping_n_s_m3", "apparent_mass_kg_m2"
PARTICLES, PATCH = "particle_mass_per_area_kg_m2", "patch_mass_per_area_kg_m2"
KINDS = {
    "particles": {"particles": {}, "model": "atlas"},
    "law": {"law": "paper_corrected"},
    "table": {"table": "lab.csv", "interpolation": "linear", "apparent_mass": "particles"},
    "impedance": {"impedance": "z.csv", "interpolation": "log"},
    C: {C: 2000, M: 3, "equivalent_damping_error_n_s_m3": 100, "apparent_mass_error_kg_m2": 0.1,
        PARTICLES: 4},
    "loss_factor": {"loss_factor": 0.2, PARTICLES: 3, "loss_factor_error": 0.02, M: 1},
}  # fmt: skip
DAMPER = TypeAdapter(AnyDamper)


def mistakes(values):
    with pytest.raises(ValidationError) as caught:
        DAMPER.validate_python(values)
    found = mistakes_of(caught.value, BedDamper)
    return [(".".join(map(str, one.keys)), one.message) for one in found]


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_known_by_its_key(kind):
    assert set(KINDS) == {*STATED, "particles"}
    assert DAMPER.validate_python(KINDS[kind]).kind == kind


@pytest.mark.parametrize(
    ("values", "key", "message"),
    [
        ({}, "", "must have one of law, table, impedance"),
        ({M: 3}, M, "unknown key"),
        ({"law": "paper_corrected", "table": "a.csv"}, "table", "unknown key"),
        ({"law": "paper"}, "law", "must be 'paper_corrected' or 'paper_printed'"),
        ({"law": "paper_corrected", "interpolation": "log"}, "interpolation", "unknown key"),
        ({"table": "a.csv", M: 3}, M, "unknown key"),
        ({"table": "a.csv", "interpolation": "cubic"}, "interpolation", "must be 'log' or 'linear'"),
        ({"particles": {}, "model": "dem"}, "model", "must be 'coupled', 'atlas' or 'tones'"),
        ({"particles": {}, "vary": {"gravity_g": [0, 1]}}, "vary", "only in a study of the coupon alone"),
        ({C: -1}, C, "must be from 0 to 1e+08"),
        ({C: float("nan")}, C, "must be a finite number"),
        ({C: "much"}, C, "must be a number"),
        ({C: 5, M: -1}, M, "must be from 0 to 1000"),
        ({C: 5, PARTICLES: 0}, PARTICLES, "must be from 0.001 to 1000"),
        ({C: 0, "equivalent_damping_error_n_s_m3": 1}, "equivalent_damping_error_n_s_m3",
         "must be 0 where equivalent_damping_n_s_m3 is 0"),
        ({C: 5, "apparent_mass_error_kg_m2": 1}, "apparent_mass_error_kg_m2",
         "only allowed with apparent_mass_kg_m2"),
        ({C: 5, "loss_factor_error": 1}, "loss_factor_error", "unknown key"),
        ({"loss_factor": 0.1}, PARTICLES, "missing; required for loss_factor"),
        ({"loss_factor": 15, PARTICLES: 3}, "loss_factor", "must be from 0 to 2; 15 % would be 0.15"),
        ({"loss_factor": 0, PARTICLES: 3, "loss_factor_error": 0.1}, "loss_factor_error",
         "must be 0 where loss_factor is 0"),
        ({"coupon": {"gravity_g": 1}}, "coupon", "was removed; its keys are those of the damper"),
        ({C: 800, M: 357, PARTICLES: 1}, M, "more than 10 times"),
        ({C: 800, M: 1, PARTICLES: 1, "apparent_mass": "particles"}, "apparent_mass",
         "not allowed with"),
        ({C: 800, "apparent_mass": "particles"}, "apparent_mass",
         "requires particle_mass_per_area_kg_m2"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_at_its_key(values, key, message):
    assert any(found == key and told.startswith(message) for found, told in mistakes(values))


def test_zero_damping_and_zero_loss_are_allowed():
    assert DAMPER.validate_python({C: 0, M: 3}).kind == C
    assert DAMPER.validate_python({"loss_factor": 0, PATCH: 3}).kind == "loss_factor"


@pytest.mark.parametrize(
    ("header", "needs"),
    [("frequency_hz,equivalent_damping_n_s_m3\n100,1", False),
     ("# measured\nfill_fraction , frequency_hz,equivalent_damping_n_s_m3\n0.5,100,1", True)],
)  # fmt: skip
def test_a_table_asks_for_a_fill_only_where_it_has_fills(tmp_path, header, needs):
    file = tmp_path / "lab.csv"
    file.write_text(f"{header}\n")
    assert TableDamper(table=file).needs_fill == needs


STEEL = "frequency_hz,loss_factor,particle_mass_per_area_kg_m2\n100,0.1,10\n1000,0.1,10\n"


@pytest.mark.parametrize(
    ("damper", "is_massless"),
    [
        ({"table": STEEL}, True),
        ({"table": STEEL, "apparent_mass": "particles"}, False),
        ({"table": STEEL.replace("factor", "factor ")}, True),
        ({C: 800, PARTICLES: 10}, True),
        ({C: 800, M: 0.0, PARTICLES: 10}, False),
        ({C: 800}, False),
        ({"law": "paper_corrected"}, False),
    ],
)
def test_particles_with_a_mass_that_does_not_act_are_known(damper, is_massless, tmp_path):
    if "table" in damper:
        (tmp_path / "lab.csv").write_text(damper["table"])
        damper = {**damper, "table": tmp_path / "lab.csv"}
    assert DAMPER.validate_python(damper).is_massless is is_massless


def test_the_mass_of_a_table_is_that_of_the_rows_about_a_fill(tmp_path):
    rows = "fill_fraction,frequency_hz,equivalent_damping_n_s_m3,apparent_mass_kg_m2\n"
    rows += "0.2,100,1,2\n0.5,100,1,5\n0.9,100,1,9\n"
    (tmp_path / "lab.csv").write_text(rows)
    (tmp_path / "z.csv").write_text(
        "frequency_hz,impedance_real_n_s_m3,impedance_imag_n_s_m3\n100,50,1885\n200,50,1885\n"
    )
    (tmp_path / "steel.csv").write_text(STEEL)

    def mass(fill, **values):
        return DAMPER.validate_python(values).mass_of_rows(fill)

    assert [mass(f, table=tmp_path / "lab.csv") for f in (0.1, 0.2, 0.4, 0.95)] == [2, 2, 5, 9]
    assert mass(None, impedance=tmp_path / "z.csv") == pytest.approx(3.0, rel=1e-3)
    steel = {"table": tmp_path / "steel.csv"}
    assert [mass(0.5, **steel), mass(0.5, **steel, apparent_mass="particles")] == [0, 10]


@pytest.fixture
def dampers(write, tmp_path):
    """The dampers of a study, from their values."""

    def load(values, **more):
        study = yaml.safe_load((STUDIES / "smoke.yaml").read_text())
        study = {**study, **more, "dampers": values, "scenarios": {}}
        return load_study(write(tmp_path, study).path).dampers

    return load


BED = {"cell": {"depth_mm": 20}, "particles": {"diameter_mm": 2, "friction": 0.2}}


def test_a_damper_like_another_differs_in_what_it_states_alone(dampers):
    found = dampers(
        {
            "b": {"like": "a", "particles": {"friction": 0.4}},
            "c": {"like": "b", "model": "atlas"},
            "a": {**BED, "model": "tones"},
        }
    )
    a, b, c = (found[name] for name in "abc")
    assert (a.model, b.model, c.model) == ("tones", "tones", "atlas")
    assert (b.particles.friction, b.particles.diameter_mm) == (0.4, 2.0)
    assert (a.particles.friction, c.particles.friction) == (0.2, 0.4)
    assert {damper.cell.depth_mm for damper in (a, b, c)} == {20}
    assert a.bed != b.bed == c.bed


@pytest.mark.parametrize(
    ("changes", "model"),
    [
        ({}, "coupled"),
        ({"damping": {"level": {"kind": "patch"}}}, "coupled"),
        ({"damping": {"level": {"kind": "stated", "acceleration_g": 20}}}, "tones"),
        ({"damping": {"level": {"by": "element"}}}, "tones"),
        ({"response": {"frequency_hz": [100, 400], "modal_damping": "diagonal"}}, "tones"),
    ],
)
def test_particles_are_integrated_with_the_panel_unless_a_tone_is_stated(dampers, changes, model):
    assert dampers({"a": BED}, **changes)["a"].model == model


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"a": {"like": "b"}}, "dampers.a.like = b: must be one of dampers: "),
        ({"a": {"like": "a"}}, "dampers.a.like = a: must be one of dampers: "),
        ({"a": {"like": "b"}, "b": {"like": "a"}}, "leads back to"),
        ({"a": BED, "b": {"like": "a", "law": "paper"}}, "dampers.b.law = paper: must be"),
        ({"a": {"like": [1]}}, "dampers.a.like"),
    ],
)
def test_a_damper_like_nothing_is_told_at_its_line(refusal, values, message):
    study = yaml.safe_load((STUDIES / "smoke.yaml").read_text())
    (line,), _ = refusal({**study, "dampers": values, "scenarios": {}})
    assert message in line
