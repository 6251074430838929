"""What the stage takes from a study."""

import numpy as np
import xarray as xr

from pidpanel.paths import STUDIES
from pidpanel.response.from_study import quietest
from pidpanel.study import load_study


def test_the_scenario_with_the_least_motion_where_the_bare_panel_moves_most_is_mapped():
    study = load_study(STUDIES / "l_panel.yaml")
    bare, *others = [scenario.label for scenario in study.all_scenarios()]
    frequency = np.array([10.0, 20.0, 40.0])
    power = {bare: (2.0, 9.0), **dict.fromkeys(others, (1.0, 5.0))}
    # at the first point it moves least, at the second most
    power[others[-1]] = (1.5, 4.0)
    values = np.array(list(power.values()))[:, None, :] * np.ones((1, 3, 1))
    names = ("scenario", "frequency", "point")
    places = {"scenario": list(power), "frequency": frequency, "point": ["a", "b"]}
    psd = xr.Dataset({"acceleration_psd": (names, values)}, places)
    assert quietest(study, psd) == others[-1]
    # without a steady response it is not mapped
    psd["acceleration_psd"].loc[{"scenario": others[-1]}] = np.nan
    assert quietest(study, psd) == others[0]
