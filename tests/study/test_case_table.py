"""The table of cases of a coupon: each row is a coupon of its own, or is refused with its line."""

import pytest
import yaml

from pidpanel.coupon.from_study import cases_of
from pidpanel.study import StudyError, load_any_study
from pidpanel.study.coupon import Coupon

HEADER = "sweep.fill_fraction, sweep.frequency_hz, sweep.acceleration_g"
TABLE = f"""# a design
{HEADER}, particles.restitution, cell.depth_mm, cell.count, gravity_direction, accuracy.seeds
0.5, 100, 20, 0.8, 25, 3, 0 0 -1, 2
0.2, 50, 2.5, 0.4, 12, 6, 1 0 0, 1
"""


def write(folder, table, **coupon):
    (folder / "design.csv").write_text(table)
    study = folder / "beds.yaml"
    study.write_text(yaml.safe_dump({"coupon": {"cases": "design.csv", **coupon}}))
    return study


def refused(folder, table, **coupon):
    with pytest.raises(StudyError) as refusal:
        load_any_study(write(folder, table, **coupon))
    return str(refusal.value).replace(f"{folder}/", "").splitlines()


def test_a_row_is_a_case_with_all_its_values(tmp_path):
    coupon = load_any_study(write(tmp_path, TABLE)).coupon
    (first, one), (_, two) = coupon.variants()
    assert first == {
        "particles.restitution": 0.8,
        "cell.depth_mm": 25.0,
        "cell.count": 3.0,
        "gravity_direction": (0.0, 0.0, -1.0),
    }
    assert (one.sweep.fill_fraction, two.sweep.fill_fraction) == ((0.5,), (0.2,))
    assert (two.sweep.frequencies, two.sweep.acceleration_g) == ((50.0,), (2.5,))
    assert (two.particles.restitution, two.cell.depth_mm, two.cell.count) == (0.4, 12.0, 6)
    assert (two.gravity_direction, two.accuracy.seeds) == ((1.0, 0.0, 0.0), 1)


def test_a_row_has_the_case_of_the_same_coupon_without_a_table(tmp_path):
    cases = cases_of(load_any_study(write(tmp_path, TABLE)).coupon)
    alone = Coupon.model_validate(
        {
            "sweep": {"fill_fraction": [0.2], "frequency_hz": [50], "acceleration_g": [2.5]},
            "particles": {"restitution": 0.4},
            "cell": {"depth_mm": 12, "count": 6},
            "gravity_direction": [1, 0, 0],
            "accuracy": {"seeds": 1},
        }
    )
    (same,) = cases_of(alone)
    assert [case.label for case in cases] == [cases[0].label, same.label]
    assert cases[1].varied["gravity_direction"] == "1 0 0"
    # each row is softened for its own drive
    soft, stiff = (case.point.constants.youngs_modulus for case in cases)
    assert soft < stiff == 3200e6


def test_a_longer_table_continues_a_shorter_one(tmp_path):
    short = [case.label for case in cases_of(load_any_study(write(tmp_path, TABLE)).coupon)]
    more = TABLE + "0.5, 100, 20, 0.8, 25, 5, 0 0 -1, 2\n"
    labels = [case.label for case in cases_of(load_any_study(write(tmp_path, more)).coupon)]
    assert labels[:2] == short
    assert len(set(labels)) == 3


@pytest.mark.parametrize(
    ("table", "message"),
    [
        ("sweep.fill_fraction, sweep.acceleration_g\n0.5, 3\n", "design.csv, line 1: missing column sweep.frequency_hz"),
        ("sweep.fill_fraction, sweep.frequency_hz\n0.5, 3\n", "design.csv, line 1: must have either column sweep.acceleration_g or sweep.displacement_mm"),
        (f"{HEADER}\n", "design.csv: must have at least one row"),
        (f"{HEADER}, particles.fricton\n0.5, 100, 20, 0.3\n", "column particles.fricton: unknown key; did you mean friction?"),
        (f"{HEADER}, sweep.diameter_mm\n0.5, 100, 20, 2\n", "column sweep.diameter_mm: cannot be varied"),
        (f"{HEADER}, particles.friction\n0.5, 100, 20, 0.3\n0.5, 100, 20, 7\n", "design.csv, line 3: particles.friction = 7.0: must be from 0 to 5; 7 % would be 0.07"),
        (f"{HEADER}\n0.5, 100, 20\n50, 100, 20\n", "design.csv, line 3: sweep.fill_fraction = 50.0: must be from 0.02 to 1; 50 % would be 0.5"),
        (f"{HEADER}, particles.friction\n0.5, 100, 20,\n", "design.csv, line 2: particles.friction: empty; must have a value"),
        (f"{HEADER}\n0.5, 100, 20\n0.5, 90, 20\n0.5, 100, 20\n", "design.csv, line 4: duplicate of line 2"),
        (f"{HEADER}\n0.5, 100\n", "design.csv, line 2: has 2 values, must have 3 as the header"),
        (f"{HEADER}, cell.depth_mm\n0.5, 100, 20, 2\n", "design.csv, line 2: particles.diameter_mm: the largest particle, 2 mm, must be at most 0.9 of the cell's across_flats_mm = 6.35 and depth_mm = 2"),
    ],
)  # fmt: skip
def test_a_mistake_in_a_table_is_one_line_with_its_place(tmp_path, table, message):
    (line,) = refused(tmp_path, table)
    assert line == f"beds.yaml:2: coupon.cases = design.csv: {message}"


def test_a_mistake_of_many_rows_is_one_line(tmp_path):
    rows = "".join(f"0.5, {f}, 20, {f}\n" for f in range(100, 600))
    (line,) = refused(tmp_path, f"{HEADER}, particles.friction\n{rows}")
    assert line.endswith("must be from 0 to 5; 100 % would be 1; likewise in lines 3 to 501")


def test_a_table_stands_in_place_of_a_sweep(tmp_path):
    sweep = {"frequency_hz": [100], "acceleration_g": [3]}
    (line,) = refused(tmp_path, TABLE, sweep=sweep)
    assert line.endswith("not allowed together with cases")
    (line,) = refused(tmp_path, TABLE, vary={"gravity_g": [0, 1]})
    assert line.endswith("not allowed together with cases")
    (tmp_path / "design.csv").unlink()
    study = tmp_path / "beds.yaml"
    study.write_text("coupon: {cases: design.csv}\n")
    with pytest.raises(StudyError, match=r"coupon.cases = design.csv: no such file"):
        load_any_study(study)
