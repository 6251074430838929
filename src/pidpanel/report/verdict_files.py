"""``coupled/verdict.csv``: scenarios that differ from coupled ones in the damping model alone.

A model holds for a scenario at a point if its g rms is within `RMS_LIMIT` of the coupled run and
every third octave within `BAND_DEPTH` of the highest is within `BAND_LIMIT`. The outcome is open if
the interval of two standard errors of the coupled run includes a limit.
"""

from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Literal, NamedTuple

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.provenance.results import read_csv
from pidpanel.report.names import Scenario, Study
from pidpanel.response.psd_files import is_steady, read_psd
from pidpanel.solve.bands import band_rms, whole_third_octaves
from pidpanel.solve.lines import root_mean_square
from pidpanel.sound.from_study import spectrum_of

RMS_LIMIT = 0.03  # largest relative difference of g rms [1]

BAND_LIMIT = 0.5  # largest difference of the rms of a third octave [dB]

BAND_DEPTH = 20.0  # third octaves further below the highest are ignored [dB]

Holds = Literal["yes", "no", "open"]


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


class CoupledRun(NamedTuple):
    """A point of a coupled run."""

    rms: float  # [g]
    rms_error: float  # [g]
    band_rms: Array  # (n,) of third octaves [g]
    band_error_db: Array  # (n,) [dB]


class Distance(NamedTuple):
    """Difference between a damping model and the coupled run at a point, named as in the table."""

    difference: float  # g rms over that of the coupled run, less 1
    coupled_g_rms_relative_error: float  # standard error of the coupled run
    band: int  # index of the third octave with the largest difference
    band_difference_db: float  # its difference [dB]
    band_error_db: float  # [dB]
    holds: Holds  # whether both are within their limits


def distance(rms: float, band_rms: Array, coupled: CoupledRun) -> Distance:
    """Return the difference between a damping model and a coupled run.

    Examples
    --------
    >>> run = CoupledRun(10.0, 0.05, np.array([8.0, 6.0, 0.01]), np.array([0.1, 0.1, 0.1]))
    >>> offset = distance(10.1, np.array([8.0, 6.2, 0.02]), run)
    >>> offset.band, round(offset.band_difference_db, 2), offset.holds
    (1, 0.28, 'yes')
    """
    counts = coupled.band_rms >= 10 ** (-BAND_DEPTH / 20) * coupled.band_rms.max()
    gap = np.zeros(counts.shape)
    gap[counts] = 20 * np.log10(band_rms[counts] / coupled.band_rms[counts])
    band = int(np.argmax(np.abs(gap)))
    relative, error = rms / coupled.rms - 1, coupled.rms_error / coupled.rms
    outcomes = {
        _holds(relative, error, RMS_LIMIT),
        *(
            _holds(value, error_db, BAND_LIMIT)
            for value, error_db in zip(gap[counts], coupled.band_error_db[counts], strict=True)
        ),
    }
    return Distance(
        float(relative), float(error), band, float(gap[band]), float(coupled.band_error_db[band]),
        combined(outcomes),
    )  # fmt: skip


def combined(outcomes: Collection[Holds]) -> Holds:
    """Return the combined outcome: no outweighs open, and open outweighs yes."""
    return "no" if "no" in outcomes else "open" if "open" in outcomes else "yes"


def _holds(gap: float, error: float, limit: float) -> Holds:
    if abs(gap) + 2 * error <= limit:
        return "yes"
    return "no" if abs(gap) - 2 * error > limit else "open"
