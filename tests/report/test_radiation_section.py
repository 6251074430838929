"""What the report says of the air beside the damper."""

import pandas as pd

from pidpanel.report.radiation_section import compared, radiation_finding, radiation_section


def frames(damped_beside):
    """Bare 28 → 14 g (6.0 dB); a damper takes 4 dB, and so many dB beside."""
    of = {"reading": "dem", "point": "centre"}
    summary = pd.DataFrame(
        [
            {
                **of,
                "scenario": "bare",
                "patch": "none",
                "status": "ok",
                "acceleration_rms_g": 28.0,
                "reduction_db": 0.0,
            },
            {
                **of,
                "scenario": "A_r0.5",
                "patch": "A",
                "status": "ok",
                "acceleration_rms_g": 17.7,
                "reduction_db": 4.0,
            },
            {**of, "scenario": "A_r0.9", "patch": "A", "status": "unstable"},
        ]
    )
    radiation = pd.DataFrame(
        [
            {
                **of,
                "radiation": "one_side",
                "scenario": "bare",
                "acceleration_rms_g": 14.0,
                "reduction_db": 0.0,
            },
            {
                **of,
                "radiation": "one_side",
                "scenario": "A_r0.5",
                "acceleration_rms_g": 11.0,
                "reduction_db": damped_beside,
            },
        ]
    )
    return summary, radiation


def test_the_finding_says_what_the_air_takes_and_that_the_gain_is_overstated():
    # red: reduction(bare, beside) the other way round; `less > 0.5` → `less < 0.5`
    alone = radiation_finding(compared(*frames(2.0)), "none", ["centre"], air_mass=False)
    assert "(resistance without added mass)" in alone  # red: if air_mass → if not air_mass
    text = radiation_finding(compared(*frames(2.0)), "none", ["centre"])
    assert "(added mass included)" in text
    assert "from 28.0 to 14.0 g rms (−6.0 dB)" in text
    assert "is 2.0 dB instead of 4.0 dB" in text
    assert "overestimated" in text


def test_a_gain_that_does_not_shrink_is_not_called_overstated():
    # red: the verdict without its condition
    text = radiation_finding(compared(*frames(4.5)), "none", ["centre"])
    assert "overestimated" not in text
    assert "smaller in 0 % of the scenarios and points only" in text


def test_scenarios_with_a_response_are_in_the_table():
    section = radiation_section(*frames(2.0), "none", ["centre"])
    table = section.blocks[1]
    assert [row[1] for row in table.rows] == ["bare", "A_r0.5"]
    assert table.rows[1][3:] == ["17.7", "11.0", "4.00", "2.00"]
