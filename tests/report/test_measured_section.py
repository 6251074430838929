"""Measured points on the page of a coupon."""

import numpy as np
import pandas as pd
import pytest

from pidpanel.report.measured_section import agreement, measured_figure, measured_section

C, M = "equivalent_damping_n_s_m3", "apparent_mass_kg_m2"


@pytest.fixture
def compared():
    rows = {
        "fill_fraction": [0.3, 0.3, 0.7], "frequency_hz": [100.0, 400.0, 100.0],
        "acceleration_g": [12.0, 12.0, 12.0],
        f"measured_{C}": [165.0, 600.0, 385.0], f"measured_{C}_error": [4.0, 9.0, np.nan],
        f"simulated_{C}": [150.0, np.nan, 350.0], f"simulated_{C}_error": [3.0, np.nan, 5.0],
        f"atlas_{C}": [180.0, 500.0, np.nan], f"atlas_{C}_error": [12.0, 40.0, np.nan],
    }  # fmt: skip
    none = {f"{s}_{M}{e}": [np.nan] * 3 for s in ("measured", "simulated", "atlas")
            for e in ("", "_error")}  # fmt: skip
    return pd.DataFrame(rows | none)


def test_differences_have_the_errors_of_both(compared):
    (block,) = measured_section(compared).blocks
    (quantity,) = block.values["quantities"]
    first, second, third = (
        {name: (value, error) for name, value, error in row["sources"]} for row in quantity["rows"]
    )
    assert list(first) == [
        "measured", "simulated", "atlas", "measured − simulated", "measured − atlas",
        "simulated − atlas",
    ]  # fmt: skip
    assert first["measured − simulated"] == (15.0, 5.0)
    assert first["measured − atlas"] == pytest.approx((-15.0, np.hypot(4, 12)))
    assert np.isnan(second["measured − simulated"][0])
    assert third["measured − simulated"] == (35.0, 5.0)


def test_the_agreement_is_that_of_points_that_both_have(compared):
    # measured over simulated is 1.1 twice, with differences of 3 and 7 standard errors
    assert agreement(compared, "simulated") == pytest.approx(
        {"name": "simulated", "points": 2, "ratio": 1.1, "rms": np.log(1.1), "z": np.sqrt(29)}
    )
    nowhere = compared.assign(**{f"atlas_{C}": np.nan})
    assert agreement(nowhere, "atlas") == {"name": "atlas", "points": 0}


def test_the_variant_nearest_to_the_measurement_comes_first_and_is_shown(compared):
    # simulated C_e of 350, 385 and 300 at a measured 385; one of them has a point more
    variants = []
    for friction, damping in ((0.1, 350.0), (0.3, 385.0), (0.5, 300.0)):
        rows = compared.assign(**{"particles.friction": friction})
        rows.loc[2, f"simulated_{C}"] = damping
        variants.append(rows)
    variants[1].loc[0, f"simulated_{C}"] = np.nan
    (block,) = measured_section(pd.concat(variants), ["particles.friction"]).blocks
    order = [variant["values"]["particles.friction"] for variant in block.values["variants"]]
    assert order == [0.1, 0.5, 0.3]
    shown = {row["particles.friction"] for row in block.values["quantities"][0]["rows"]}
    assert shown == {0.1}


def test_the_figure_has_a_column_for_each_fill_and_what_is_measured(compared):
    figure = measured_figure(compared)
    assert [axes.get_title("left") for axes in figure.axes] == ["r = 0.3", "r = 0.7"]
    lines = [line for line in figure.axes[0].lines if line.get_marker() == "o"]
    assert [line.get_ydata().tolist() for line in lines] == [[165.0, 600.0]]
    with_mass = measured_figure(compared.assign(**{f"measured_{M}": 1.0}))
    assert len(with_mass.axes) == 4
