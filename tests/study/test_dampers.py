"""One damper of a study: exactly one kind, and only the keys that belong to it."""

import pytest
from pydantic import ValidationError

from pidpanel.study.dampers import ALLOWED, DamperSection, mass_in_table
from pidpanel.study.damping import Damping
from pidpanel.study.mistakes import mistakes_of

SWEEP = {"frequency_hz": [100], "acceleration_g": [10]}
C, M = "equivalent_damping_n_s_m3", "apparent_mass_kg_m2"
PARTICLES, PATCH = "particle_mass_per_area_kg_m2", "patch_mass_per_area_kg_m2"
KINDS = {
    "coupon": {"coupon": {"sweep": SWEEP}},
    "law": {"law": "paper_corrected"},
    "table": {"table": "lab.csv", "interpolation": "linear", "apparent_mass": "particles"},
    "impedance": {"impedance": "z.csv", "interpolation": "log"},
    C: {C: 2000, M: 3, "equivalent_damping_error_n_s_m3": 100, "apparent_mass_error_kg_m2": 0.1,
        PARTICLES: 4},
    "loss_factor": {"loss_factor": 0.2, PARTICLES: 3, "loss_factor_error": 0.02, M: 1},
}  # fmt: skip


def mistakes(values):
    with pytest.raises(ValidationError) as caught:
        DamperSection.model_validate(values)
    return [
        (".".join(map(str, one.keys)), one.message)
        for one in mistakes_of(caught.value, DamperSection)
    ]


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_is_one(kind):
    # red: a kind left out of ALLOWED
    assert set(KINDS) == set(ALLOWED)
    assert DamperSection.model_validate(KINDS[kind]).kind == kind


@pytest.mark.parametrize(
    ("values", "key", "message"),
    [
        ({}, "", "must have exactly one of coupon, law, table, impedance, "
         "equivalent_damping_n_s_m3, loss_factor, not none"),
        ({M: 3}, "", "must have exactly one of"),
        ({"law": "paper_corrected", "table": "a.csv"}, "", "must have exactly one of"),
        ({"law": "paper"}, "law", "must be 'paper_corrected' or 'paper_printed'"),
        ({"law": "paper_corrected", "interpolation": "log"}, "interpolation",
         "only allowed with table or impedance"),
        ({"table": "a.csv", M: 3}, M, "only allowed with equivalent_damping_n_s_m3 or loss_factor"),
        ({"table": "a.csv", "interpolation": "cubic"}, "interpolation", "must be 'log' or 'linear'"),
        ({"tabel": "a.csv"}, "tabel", "unknown key; did you mean table?"),
        ({C: -1}, C, "must be from 0 to 1e+08"),
        ({C: float("nan")}, C, "must be a finite number"),
        ({C: "much"}, C, "must be a number"),
        ({C: 5, M: -1}, M, "must be from 0 to 1000"),
        ({C: 5, PARTICLES: 0}, PARTICLES, "must be from 0.001 to 1000"),
        ({C: 0, "equivalent_damping_error_n_s_m3": 1}, "equivalent_damping_error_n_s_m3",
         "must be 0 where equivalent_damping_n_s_m3 is 0"),
        ({C: 5, "apparent_mass_error_kg_m2": 1}, "apparent_mass_error_kg_m2",
         "only allowed with apparent_mass_kg_m2"),
        ({C: 5, "loss_factor_error": 1}, "loss_factor_error", "only allowed with loss_factor"),
        ({C: 5, PATCH: 1}, PATCH, "only allowed with loss_factor"),
        ({"loss_factor": 0.1}, PARTICLES, "missing; required for loss_factor"),
        ({"loss_factor": 15, PARTICLES: 3}, "loss_factor", "must be from 0 to 2; 15 % would be 0.15"),
        ({"loss_factor": 0, PARTICLES: 3, "loss_factor_error": 0.1}, "loss_factor_error",
         "must be 0 where loss_factor is 0"),
        ({"coupon": {"sweep": SWEEP, "vary": {"gravity_g": [0, 1]}}}, "coupon.vary",
         "only allowed in a study without a panel"),
    ],
)  # fmt: skip
def test_a_mistake_is_told_at_its_key(values, key, message):
    # red: the line that yields it left out
    ((found, told),) = mistakes(values)
    assert found == key
    assert told.startswith(message)


def test_zero_damping_and_zero_loss_are_allowed():
    # red: NotNegative → Positive
    assert DamperSection.model_validate({C: 0, M: 3}).kind == C
    assert DamperSection.model_validate({"loss_factor": 0, PATCH: 3}).kind == "loss_factor"


def test_the_interpolation_of_the_table_needs_a_table():
    # red: the mistake left out of Damping.mistakes
    Damping.model_validate({"readings": ["table"], "table": "a.csv", "interpolation": "linear"})
    with pytest.raises(ValidationError, match="interpolation: only allowed with table"):
        Damping.model_validate({"interpolation": "linear"})


@pytest.mark.parametrize(
    ("header", "asked"),
    [("frequency_hz,equivalent_damping_n_s_m3", False),
     ("# measured\nfill_fraction , frequency_hz,equivalent_damping_n_s_m3", True)],
)  # fmt: skip
def test_a_table_asks_for_a_fill_only_where_it_has_fills(tmp_path, header, asked):
    # red: return True; header taken from the first line, comment or not
    file = tmp_path / "lab.csv"
    file.write_text(f"{header}\n")
    assert DamperSection.model_construct(table=file).is_of_a_fill == asked


STEEL = "frequency_hz,loss_factor,particle_mass_per_area_kg_m2\n100,0.1,10\n1000,0.1,10\n"


@pytest.mark.parametrize(
    ("damper", "is_massless"),
    [
        ({"table": STEEL}, True),
        ({"table": STEEL, "apparent_mass": "particles"}, False),
        ({"table": STEEL.replace("factor", "factor ")}, True),
        ({"equivalent_damping_n_s_m3": 800, "particle_mass_per_area_kg_m2": 10}, True),
        ({"equivalent_damping_n_s_m3": 800, "apparent_mass_kg_m2": 0.0,
          "particle_mass_per_area_kg_m2": 10}, False),
        ({"equivalent_damping_n_s_m3": 800}, False),
        ({"law": "paper_corrected"}, False),
    ],
)  # fmt: skip
def test_particles_with_a_mass_that_does_not_act_are_known(damper, is_massless, tmp_path):
    # red: no `is_massless`; apparent_mass left out of it
    if "table" in damper:
        (tmp_path / "lab.csv").write_text(damper["table"])
        damper = {**damper, "table": tmp_path / "lab.csv"}
    assert DamperSection(**damper).is_massless is is_massless


@pytest.mark.parametrize(
    ("values", "message"),
    [
        ({"apparent_mass_kg_m2": 357, "particle_mass_per_area_kg_m2": 1}, "more than 10 times"),
        ({"apparent_mass_kg_m2": 1, "apparent_mass": "particles"}, "not allowed with"),
        ({"apparent_mass": "particles"}, "requires particle_mass_per_area_kg_m2"),
    ],
)
def test_an_apparent_mass_far_above_that_of_the_particles_is_refused(values, message):
    # red: no bound of the apparent mass
    assert any(message in told for _, told in mistakes({C: 800, **values}))


def test_the_mass_of_a_table_is_that_of_the_rows_about_a_fill(tmp_path):
    # red: all rows, whatever the fill; Im Z without ω
    rows = "fill_fraction,frequency_hz,equivalent_damping_n_s_m3,apparent_mass_kg_m2\n"
    rows += "0.2,100,1,2\n0.5,100,1,5\n0.9,100,1,9\n"
    (tmp_path / "lab.csv").write_text(rows)
    (tmp_path / "z.csv").write_text(
        "frequency_hz,impedance_real_n_s_m3,impedance_imag_n_s_m3\n100,50,1885\n200,50,1885\n"
    )
    found = [mass_in_table(tmp_path / "lab.csv", fill, None) for fill in (0.1, 0.2, 0.4, 0.95)]
    assert found == [2, 2, 5, 9]
    assert mass_in_table(tmp_path / "z.csv", None, None) == pytest.approx(3.0, rel=1e-3)
    (tmp_path / "steel.csv").write_text(STEEL)
    assert [mass_in_table(tmp_path / "steel.csv", 0.5, way) for way in (None, "particles")] == [
        0, 10,
    ]  # fmt: skip
