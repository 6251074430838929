"""From some levels to others: what is known is kept, what is not is said."""

from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from pidpanel.coupled.carried import carried_impedances, extrapolated, interpolated, nearest
from pidpanel.damping.coupled import BAND_COLUMNS, BandDamping

ONES = np.ones(3)
LOW, HIGH = (
    BandDamping(**{name: value * ONES for name, value in zip(BAND_COLUMNS, values, strict=True)})
    for values in ((800, 40, 2, 0.1, 4, 0.2), (200, 20, 0, 0.1, 16, 0.8))
)


def test_only_neighbours_are_carried():
    # red: `off.min() > apart` → `> 2 * apart`; `<= 2 * apart` left out of the sides
    assert nearest(139.0, [136.7, 152.0], 3.0) == (0,)
    assert nearest(136.7, [122.0, 136.7, 142.0], 3.0) == (1, 2)
    with pytest.raises(ValueError, match="142 dB: no neighbour within 3 dB"):
        nearest(142.0, [136.7, 152.0], 3.0)


def test_a_level_has_a_neighbour_on_each_side_within_twice_the_largest_distance():
    # red: sides told by 1 dB; distances with a sign; three times the largest distance
    assert nearest(139.5, [139.0, 140.0], 3.0) == (0, 1)
    assert nearest(139.0, [139.5, 150.0], 3.0) == (0,)
    assert nearest(142.0, [120.0, 143.0], 3.0) == (1,)
    assert nearest(142.0, [134.5, 143.0], 3.0) == (1,)


def test_an_own_force_of_zero_is_a_million_millionth_of_the_largest():
    # red: the floor from the smallest, from one side alone, or over the largest
    first = replace(LOW, own_psd=np.array([0.0, 2.0, 40.0]))
    second = replace(HIGH, own_psd=np.array([16.0, 1.0, 8.0]))
    for low, high in ((first, second), (second, first)):
        expected = [np.sqrt(40e-12 * 16), np.sqrt(2.0), np.sqrt(320.0)]
        assert interpolated(0.5, low, high).own_psd == pytest.approx(np.array(expected))


def test_between_two_levels_damping_is_a_power_of_the_motion():
    # red: mean of C_e itself (500); own force not in its ln; coherence of the one level
    found = interpolated(0.5, LOW, HIGH)
    assert found.equivalent_damping == pytest.approx(400 * ONES)
    assert found.apparent_mass == pytest.approx(ONES)
    assert found.own_psd == pytest.approx(8 * ONES)
    assert found.own_coherence == pytest.approx(0.5 * ONES)
    # half of 5 % and half of 10 %, independent
    assert found.equivalent_damping_error / 400 == pytest.approx(np.hypot(0.025, 0.05) * ONES)


@pytest.mark.parametrize("bend", [-1.0, 1.0])
def test_the_common_error_holds_a_law_that_bends(bend):
    # ln C_e = a + b s + c s² with b = 0 or c = −b/… : one end flat, as the module says
    # red: share * (1 - share) → share * (1 - share) / 4
    def at(share):
        rise = share**2 if bend > 0 else 2 * share - share**2
        return replace(LOW, equivalent_damping=np.exp(6 - 1.4 * rise) * ONES)

    for share in (0.2, 0.5, 0.8):
        found = interpolated(share, at(0.0), at(1.0))
        apart = np.log(found.equivalent_damping / at(share).equivalent_damping)
        assert np.abs(apart) == pytest.approx(found.common_error * ONES, rel=1e-6)
    assert interpolated(0.0, at(0.0), at(1.0)).common_error == 0


def test_beyond_all_levels_the_error_is_that_of_one_over_the_motion():
    # red: / 20 → / 10
    found = extrapolated(-6.0206, LOW)
    assert found.common_error == pytest.approx(np.log(2), rel=1e-4)
    assert found.equivalent_damping is LOW.equivalent_damping


def test_rows_say_where_they_come_from():
    # red: scenario left out of assign; the patches of the first alone
    def rows(bed, scenario):
        values = {column: getattr(bed, name) for name, column in BAND_COLUMNS.items()}
        one = pd.DataFrame(values).assign(
            scenario=scenario, patch="P", common_error=0.0, carried_from=""
        )
        return pd.concat([one, one.assign(patch="Q")])

    near = [(130.0, rows(LOW, "l")), (140.0, rows(HIGH, "h"))]
    found = carried_impedances("m", "l and h", 135.0, near)
    assert found.groupby("patch").size().to_dict() == {"P": 3, "Q": 3}
    assert set(found["scenario"]) == {"m"}
    assert set(found["carried_from"]) == {"l and h"}
    assert found["equivalent_damping_n_s_m3"].to_numpy() == pytest.approx(400.0)
    assert found["common_error"].iloc[0] == pytest.approx(np.log(4) / 4)
    (own,) = (
        carried_impedances("m", "h", 150.0, near[1:])
        .groupby("patch")
        .get_group("P")["common_error"]
        .unique()
    )
    assert own == pytest.approx(np.log(10) / 2)


def test_patches_of_one_band_are_carried_each_from_its_own_rows_in_their_order():
    # red: patches sorted; the rows of the other patch; the second band for the first
    def rows(scale):
        bands = {column: [scale, 9 * scale] for column in BAND_COLUMNS.values()}
        return pd.DataFrame(bands | {"patch": ["Q", "P"], "common_error": [0.1, 0.2]})

    carried = carried_impedances("m", "l, h", 135.0, [(130.0, rows(1.0)), (140.0, rows(4.0))])
    assert list(carried["patch"]) == ["Q", "P"]
    assert list(carried["equivalent_damping_n_s_m3"]) == pytest.approx([2.0, 18.0])
    assert list(carried["common_error"]) == pytest.approx(
        [np.hypot(np.log(4) / 4, 0.1), np.hypot(np.log(4) / 4, 0.2)]
    )
