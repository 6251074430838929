"""Studies that cannot be meant are refused at their line, with key, kind and the likely unit."""

from pathlib import Path

import pytest
import yaml

STUDIES = yaml.safe_load((Path(__file__).parent / "wrong.yaml").read_text("utf-8"))["studies"]


def listed(values):
    return f"[{', '.join(map(str, values))}]"


FRICTIONS, RESTITUTIONS = (
    listed(f"{start + k / 1000}" for k in range(count)) for start, count in ((0, 2000), (0.1, 800))
)
TOO_MUCH = [
    ("[100, 400]\n    acceleration_g: [10, 100]", f"{{from: 1, to: 2000, step: 1}}\n    acceleration_g: {listed(range(1, 1001))}", "@sweep:| coupon.sweep: too many"),
    ("[0.4, 0.8]", listed(f"{0.02 + k * 1e-6:.6f}" for k in range(60000)), "@sweep:| coupon.sweep: too many"),
    ("accuracy:", f"vary: {{particles.friction: {FRICTIONS}, particles.restitution: {RESTITUTIONS}}}\n  accuracy:", "@vary| coupon.vary: too many"),
    ("depth_mm: 10", "depth_mm: " + "[" * 2000 + "]" * 2000, "@| too many"),
    ("", "# " + "x" * 1_100_000 + "\n", "@| too many"),
]  # fmt: skip


@pytest.mark.parametrize(
    ("base", "case"),
    [(base, case) for base, cases in STUDIES.items() for case in cases],
    ids=lambda value: repr(value if isinstance(value, str) else value[1][:50]),
)
def test_what_cannot_be_meant_is_refused(wrong, base, case):
    # red: `return number` for the `raise` in Quantity.__call__; no units; yaml.SafeLoader's
    # resolvers in `Loader`; `_check_layouts`, `_check_masses` without its yield; found_file
    # without one of its conditions
    wrong(base, *case)


def test_more_fills_than_a_search_ends_with_are_refused(wrong):
    # red: 10,000 of them, with no end after 150 s
    fills = listed(f"{0.1 + k / 100:.2f}" for k in range(51))
    change = f"mass_kg: 0.9\n  fill_fraction: {fills}"
    wrong("design", "mass_kg: 0.9", change, "@fill_fraction|optimise.fill_fraction: count")


@pytest.mark.parametrize("case", TOO_MUCH, ids=lambda case: case[1][:30])
def test_what_is_too_much_is_refused(wrong, case):
    # red: no `MOST_RUNS`, no `LARGEST`
    wrong("coupon", *case)
