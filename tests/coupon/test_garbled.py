"""Whatever ran before or becomes of its checkpoint: a run has its own numbers."""

import math
import random
import shutil

import pytest

from pidpanel.coupon import attempts, summary
from tests.coupons import small_cases

pytestmark = pytest.mark.liggghts

# ------------------------------------------------------------------ what can happen to a file


def noise(data, rng):
    """Bytes that are no text."""
    at = rng.randrange(len(data))
    return data[:at] + bytes(rng.randrange(128, 256) for _ in range(8)) + data[at:]


def flipped_bit(data, rng):
    """One bit is the other, wherever it is."""
    at = rng.randrange(len(data))
    return data[:at] + bytes([data[at] ^ 1 << rng.randrange(8)]) + data[at + 1 :]


def missing(data, rng):
    """The file is not there."""
    return None


# ------------------------------------------------------------------ after a run


def case_to(cycles):
    """A case of one seed that runs so many cycles."""
    limits = {"min_time_s": 0, "min_cycles": cycles, "max_cycles": cycles}
    (case,) = small_cases(
        cell={"depth_mm": 8}, particles={"diameter_mm": 3},
        sweep={"fill_fraction": [0.6], "acceleration_g": [20]},
        accuracy={"relative_error": 0.9, "seeds": 1, **limits},
    )  # fmt: skip
    return case


def shake(folder, cycles):
    """Shake the case in results/coupon; its row of cases.csv."""
    case = case_to(cycles)
    run = case.point
    packing = folder / "packing" / run.packing.label / "packing.json"
    bed = folder / "bed" / run.bed.label / "bed.json"
    if not packing.parent.exists():
        attempts.pour_packing(run.packing, packing)
        attempts.loosen_bed(run.bed, packing, bed)
    attempts.write_case(case, folder, case.outcome_file(folder))
    return summary.summarise(case, *summary.read_seeds(case, folder))


@pytest.fixture(scope="module")
def shaken(tmp_path_factory):
    """results/coupon with a run of two legs, its row, and the row that it has after 24 cycles."""
    folder, other = tmp_path_factory.mktemp("shaken"), tmp_path_factory.mktemp("longer")
    shake(folder, 12)
    row = shake(folder, 18)
    assert row["status"] == "ok", row["message"]
    shutil.copytree(folder, other / "coupon")
    return folder, row, shake(other / "coupon", 24)


def alike(one, other):
    """Whether two rows say the same."""
    return all(
        a == b or (isinstance(a, float) and math.isnan(a) and math.isnan(b))
        for a, b in zip(one.values(), other.values(), strict=True)
    )


def test_what_ran_before_changes_no_bit(shaken, tmp_path):
    folder, row, longer = shaken
    assert alike(shake(tmp_path / "anew", 24), longer)
    assert alike(shake(tmp_path / "anew", 18), row)  # less than has been run
    other = tmp_path / "coupon"
    shutil.copytree(folder, other)
    home = case_to(18).folders(other)[0]
    assert alike(shake(other, 18), row)
    assert (home / "at_18.dump").is_file()
    closures = {one["closure"] for one in (row, longer, summary_at(folder, 12))}
    assert len(closures) == 3  # so that one in place of another shows


def summary_at(folder, cycles):
    case = case_to(cycles)
    return summary.summarise(case, *summary.read_seeds(case, folder))


HEALED = [
    ("run", "at_18.restart", flipped_bit),
    ("run", "start.data", missing),
    ("run", "cycles_2.txt", noise),
    ("bed", "bed.json", missing),
]


@pytest.mark.parametrize(
    ("where", "name", "kind"), HEALED, ids=[f"{w}-{n}-{k.__name__}" for w, n, k in HEALED]
)
def test_a_run_whose_checkpoint_cannot_be_read_begins_anew_to_the_same_numbers(
    shaken, tmp_path, where, name, kind
):
    folder, _, longer = shaken
    own = tmp_path / "coupon"
    shutil.copytree(folder, own)
    run = case_to(24).point
    home = {"run": case_to(24).folders(own)[0], "bed": own / "bed" / run.bed.label}[where]
    damage(home / name, kind)
    if where == "bed":  # it is asked for again when the run begins anew
        damage(case_to(24).folders(own)[0] / "at_18.restart", missing)
    row = shake(own, 24)
    assert row["status"] == "ok", row["message"]
    assert row["cycles_run"] == 24
    assert alike(row, longer)


def damage(path, kind):
    data = kind(path.read_bytes(), random.Random(7))
    path.unlink()
    if data is not None:
        path.write_bytes(data)
