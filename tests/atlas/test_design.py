"""The design of the atlas: cases that can exist, any first part of them over the whole space."""

import math

import atlas_design as design
import numpy as np
import pytest
from atlas_design import (
    BOUNCING_CONTACT,
    Groups,
    bounces,
    exclusion,
    packings,
    points,
    row_of,
    time_step_rayleigh,
)

from pidpanel.atlas.groups import USUAL
from pidpanel.coupon import contact
from pidpanel.coupon.from_study import cases_of
from pidpanel.paths import PROJECT, STUDIES
from pidpanel.study.coupon_study import VariedCoupon

MATERIAL = {"diameter_mm": 2, "density_kg_m3": 1190, "youngs_modulus_mpa": 3200, "poissons_ratio": 0.35}  # fmt: skip


def cases(chosen, folder):
    rows = [row_of(groups, USUAL) for groups in chosen]
    lines = [",".join(rows[0]), *(",".join(map(str, row.values())) for row in rows)]
    (folder / "cases.csv").write_text("\n".join(lines) + "\n")
    coupon = {"cases": folder / "cases.csv", "particles": MATERIAL}
    return cases_of(VariedCoupon.model_validate(coupon))


def test_a_longer_design_begins_with_the_shorter():
    assert list(points(700))[:100] == list(points(100))


def test_the_table_of_the_atlas_is_that_of_the_design():
    table = PROJECT / "workflow" / "studies" / "atlas_cases.csv"
    lines = table.read_text().splitlines()
    chosen = (groups for groups in points(1280) if not exclusion(groups, USUAL))
    rows = [row_of(groups, USUAL) for groups in chosen]
    assert lines[0] == ",".join(rows[0])
    assert lines[1:] == [",".join(map(str, row.values())) for row in rows]


@pytest.mark.parametrize("count", [64, 128, 256])
def test_any_first_part_fills_the_space(count):
    first = list(points(count))
    for values, low, high in (
        ([groups.fill_fraction for groups in first], 0.05, 0.95),
        ([math.log(groups.gamma) for groups in first], math.log(1.5), math.log(700)),
        ([groups.restitution for groups in first], 0.3, 0.95),
    ):
        quarters, _ = np.histogram(values, bins=4, range=(low, high))
        assert quarters == pytest.approx(count / 4, abs=2)
    for low, high, share in ((1e-5, 0.05, 0.45), (0.05, 1.0, 0.4), (1.0, 20.0, 0.15)):
        part = np.mean([low < groups.stroke_per_gap < high for groups in first])
        assert part == pytest.approx(share, abs=0.03)


def test_a_row_is_a_case_with_its_groups(tmp_path):
    chosen = [groups for groups in points(64) if not exclusion(groups, USUAL)]
    for groups, case in zip(chosen, cases(chosen, tmp_path), strict=True):
        run, drive = case.point, case.point.drive
        # four digits are written
        assert run.fill_fraction == pytest.approx(groups.fill_fraction, rel=1e-3)
        assert drive.gamma == pytest.approx(groups.gamma, rel=1e-3)
        assert run.bed.stroke_per_gap(drive) == pytest.approx(groups.stroke_per_gap, rel=0.02)
        assert run.packing.depth / run.packing.diameter == pytest.approx(groups.depth, rel=1e-3)
        assert run.constants.wall_friction == pytest.approx(groups.friction, rel=1e-3)
        assert (run.bed.gravity == 0) == (groups.direction == "none")
        assert run.time_step / contact.ElasticSphere(
            1e-3, 1190, run.constants.youngs_modulus, 0.35
        ).rayleigh_time <= time_step_rayleigh(groups.restitution) * (1 + 1e-9)


def test_a_bed_that_bounces_has_short_contacts_or_those_of_its_material(tmp_path):
    chosen = [g for g in points(256) if bounces(g) and not exclusion(g, USUAL)]
    assert {g.direction for g in chosen} == {"flat"} and max(g.gamma for g in chosen) < 10
    for case in cases(chosen, tmp_path):
        run = case.point
        soft = run.constants.youngs_modulus < 3200e6
        duration = run.contact_time_at(run.constants.youngs_modulus) * run.drive.frequency
        assert duration <= BOUNCING_CONTACT * 1.01 if soft else True


def test_packings_serve_many_cases(tmp_path):
    chosen = [groups for groups in points(256) if not exclusion(groups, USUAL)]
    poured = {run.packing for case in cases(chosen, tmp_path) for run in case.runs}
    assert len([packing for packing in poured if packing.seed == 1]) <= 32 < len(chosen)
    assert packings(64)[:32] == packings(32)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        ({"fill_fraction": 0.05, "width": 2.0, "depth": 4.0}, "fewer than 2 particles in a cell"),
        ({"direction": "none"}, "no gravity"),
        ({"width": 2.2, "depth": 34.6}, "too narrow and deep"),
        ({"stroke_per_gap": 20.0, "gamma": 1.5, "depth": 40.0}, "a frequency outside 3 to 10000 Hz"),
        ({"stroke_per_gap": 20.0, "gamma": 700.0, "depth": 40.0}, "overlaps of more than 0.1 radii"),
        ({"stroke_per_gap": 1e-4, "gamma": 300.0}, "contacts of more than 0.1 periods"),
        ({"stroke_per_gap": 0.05, "gamma": 2.0, "depth": 30.0, "width": 7.0}, "steps of a particle"),
    ],
)  # fmt: skip
def test_a_case_that_cannot_be_is_left_out_with_its_reason(change, reason):
    groups = Groups(0.5, 20.0, 0.01, 0.8, 0.3, 3.2, 12.5, "flat")
    assert exclusion(groups, USUAL) == ""
    assert reason in exclusion(Groups(**{**vars(groups), **change}), USUAL)


@pytest.mark.parametrize(
    ("arguments", "table", "least"),
    [("16", "atlas_cases.csv", 2), ("1600 --skip 1280 --upright", "atlas_upright_cases.csv", 41)],
)
def test_a_table_begins_with_the_points_of_the_design(monkeypatch, capsys, arguments, table, least):
    monkeypatch.setattr("sys.argv", ["design", *arguments.split()])
    design.main()
    lines = capsys.readouterr().out.splitlines()
    assert len(lines) >= least
    assert lines == (STUDIES / table).read_text().splitlines()[: len(lines)]
