"""``coupled/verdict.csv``: scenarios that differ from coupled ones in the damping model alone."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.provenance.results import read_csv
from pidpanel.report.names import Scenario, Study
from pidpanel.report.verdict import CoupledRun, distance
from pidpanel.response.psd_files import is_steady, read_psd
from pidpanel.solve.bands import band_rms, whole_third_octaves
from pidpanel.solve.lines import root_mean_square
from pidpanel.sound.from_study import spectrum_of

# In addition to the damping models: no damper, and its mass alone.
BARE, DEAD_WEIGHT = "bare panel", "dead weight"

# Columns of ``verdict.csv``: the coupled scenario, and the damper of the other one. Differences are
# those from the coupled run: relative for g rms, in dB for the third octave with the largest one.
COLUMNS = (
    "scenario", "oaspl_db", "damper", "point", "g_rms", "coupled_g_rms",
    "coupled_g_rms_relative_error", "difference", "band_hz", "band_difference_db", "band_error_db",
    "holds",
)  # fmt: skip


def write_verdict(
    study: Study, psd_nc: Path, summary_csv: Path, bands_csv: Path, verdict_csv: Path
) -> None:
    """Write the difference of each damping model from the coupled run, by scenario and point.

    Parameters
    ----------
    study
        The study.
    psd_nc
        ``response/psd.nc``.
    summary_csv, bands_csv
        ``coupled/summary.csv`` and ``coupled/third_octaves.csv``.
    verdict_csv
        CSV file to write.
    """
    # points may be named by numbers
    summary, bands = (read_csv(path, dtype={"point": str}) for path in (summary_csv, bands_csv))
    psd = read_psd(psd_nc)
    frequency = psd["frequency"].to_numpy()
    # as in the tables of the coupled runs
    _, edge = whole_third_octaves(*study.response.frequency_hz)
    rows = []
    for scenario in study.all_scenarios():
        run_rows = summary[summary["scenario"] == scenario.label]
        if run_rows.empty:
            continue
        scenario_bands = bands[bands["scenario"] == scenario.label]
        for damper, accelerations in _compared(study, psd, scenario):
            for point, run in run_rows.set_index("point").iterrows():
                point_bands = scenario_bands[scenario_bands["point"] == point]
                coupled = CoupledRun(
                    float(run["g_rms"]), float(run["g_rms_error"]),
                    point_bands["g_rms"].to_numpy(), point_bands["error_db"].to_numpy(),
                )  # fmt: skip
                values = accelerations.sel(point=point).to_numpy() / STANDARD_GRAVITY**2
                rms = float(root_mean_square(frequency, values))
                offset = distance(rms, band_rms(frequency, values, edge), coupled)
                rows.append(
                    {
                        "scenario": scenario.label,
                        "oaspl_db": scenario.oaspl_db or spectrum_of(study.acoustics).oaspl,
                        "damper": damper,
                        "point": point,
                        "g_rms": coupled.rms * (1 + offset.difference),
                        "coupled_g_rms": coupled.rms,
                        "band_hz": point_bands["frequency_hz"].to_numpy()[offset.band],
                        **offset._asdict(),
                    }
                )
    pd.DataFrame(rows, columns=list(COLUMNS)).to_csv(verdict_csv, index=False, float_format="%.6g")


def _compared(
    study: Study, psd: xr.Dataset, scenario: Scenario
) -> Iterator[tuple[str, xr.DataArray]]:
    """Yield acceleration PSDs that are compared: bare, dead weight and other damping models."""
    others = [s for s in study.alternatives(scenario) if not study.is_coupled_scenario(s)]
    yield BARE, psd["acceleration_psd"].sel(scenario=scenario.bare.label)
    for other in others:
        dead = psd["dead_weight_acceleration_psd"].sel(scenario=other.label)
        if not bool(np.isnan(dead).any()):
            yield DEAD_WEIGHT, dead
            break
    for other in others:
        if is_steady(psd, other.label):
            yield other.dampers, psd["acceleration_psd"].sel(scenario=other.label)
