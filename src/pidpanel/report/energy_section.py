"""High frequencies on the page: both answers by third octave, one PSD of each point."""

from collections.abc import Iterator

import numpy as np
import pandas as pd

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.report import html, style
from pidpanel.report.inputs import EnergyResults, Inputs
from pidpanel.report.names import main_scenarios, with_names
from pidpanel.report.response_figures import chart_picture, psd_unit
from pidpanel.report.severity_section import drawn_scenarios
from pidpanel.report.text import common_decimals, records

POINTS = 3  # points drawn at most
DB = np.log(10) / 10  # of ln


def energy_section(energy: EnergyResults, inputs: Inputs) -> html.PageSection:
    """Return the section of a study with the key ``energy``."""
    main = [scenario.label for scenario in main_scenarios(inputs.study)]
    drawn = drawn_scenarios(inputs.summary[inputs.summary["scenario"].isin(main)])
    rows = energy.summary
    good = rows[rows["status"] == "ok"]
    refused = with_names(rows[rows["status"] != "ok"], inputs.names).drop_duplicates("scenario")
    is_bare = [s.label for s in inputs.study.all_scenarios() if s.is_bare]
    damped = good[~good["scenario"].isin(is_bare) & (good["modal_rms_g"] > 0)]
    compared = energy.bands.dropna(subset="difference_db")
    octave = compared[compared["scenario"].isin(good["scenario"])]
    octave = octave.groupby("scenario").tail(3)
    values = {
        "picture": chart_picture("energy", list(_charts(energy, inputs, drawn)), across=2),
        "first": None if good.empty else good.iloc[0],
        "largest": octave["difference_db"].abs().max(),
        "interval": records(_interval(energy.bands, good)),
        "added": (damped["acceleration_rms_g"] / damped["modal_rms_g"] - 1).abs().max(),
        "rows": records(with_names(good, inputs.names)),
        "decimals": common_decimals(good["acceleration_rms_error_g"], 0) if len(good) else 0,
        "refused": [
            {"scenarios": list(group["scenario"]), **dict(group.iloc[0])}
            for _, group in refused.groupby("status", sort=False)
        ],
    }
    return html.template_section("energy.html", "High frequencies", values)


def _interval(bands: pd.DataFrame, good: pd.DataFrame) -> pd.DataFrame:
    """Return the first band above the transition and the last, of the first scenario with both."""
    if good.empty:
        return bands.head(0)
    first = good.iloc[0]
    energies = bands[
        (bands["scenario"] == first["scenario"])
        & (bands["center_hz"] > first["transition_high_hz"])
    ]
    return energies.iloc[[0, -1]] if len(energies) > 1 else energies


def _charts(energy: EnergyResults, inputs: Inputs, drawn: list[str]) -> Iterator[html.Chart]:
    """Yield the area mean of the first scenario that is drawn, then the PSD of points."""
    colours = [style.BARE, style.PLACES[0]][: len(drawn)]
    bands = energy.bands[energy.bands["scenario"] == drawn[0]]
    error = DB * bands["mean_error_db"].to_numpy()
    curves = [
        html.PageCurve("statistical energy", bands["energy_psd_g2_hz"].to_numpy(),
                       style.PLACES[1], log_error=error),
        html.PageCurve("modal", bands["modal_psd_g2_hz"].to_numpy(), style.BARE, line="dashed"),
    ]  # fmt: skip
    name = inputs.names[drawn[0]]
    centre = bands["center_hz"].to_numpy()
    yield html.Chart(f"area mean, {name}", centre, "mean PSD, g²/Hz", curves)
    lines = energy.psd["frequency"].to_numpy()
    for point in inputs.moving_points[:POINTS]:
        curves = []
        for label, colour in zip(drawn, colours, strict=True):
            case = energy.psd.sel(scenario=label, point=point)
            psd = case["acceleration_psd"].to_numpy() / STANDARD_GRAVITY**2
            spread = case["acceleration_psd_log_error"].to_numpy()
            curves.append(html.PageCurve(inputs.names[label], psd, colour, log_error=spread))
        yield html.Chart(f"point {point}", lines, psd_unit(point), curves)
