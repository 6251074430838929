"""What the report says of the air beside the damper."""

import pandas as pd

from pidpanel.report.radiation_section import compared, radiation_section


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


def test_scenarios_with_a_response_are_in_the_table():
    # red: if air_mass → if not air_mass
    pairs = compared(*frames(2.0))
    (table,) = radiation_section(pairs, "none", air_mass=False).blocks
    assert table.caption.endswith("into the air, without added mass")
    assert [row[1] for row in table.rows] == ["bare", "A_r0.5"]
    assert table.rows[1][3:] == ["17.7", "11.0", "4.00", "2.00"]
