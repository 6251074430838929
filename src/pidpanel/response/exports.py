"""Files for other programs: CSV, third octaves, Nastran tables and dampers, UFF 58."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping_ratio import DampingRatio
from pidpanel.panel.basis import PanelBasis
from pidpanel.response.bushes import write_bushes
from pidpanel.response.cases import ResponseScenario
from pidpanel.response.export import Curve, third_octave_rows, write_tabrnd1, write_uff58
from pidpanel.response.psd_files import is_steady
from pidpanel.response.results import write_csv
from pidpanel.response.tabdmp1 import modal_damping_ratio, write_tabdmp1
from pidpanel.response.trust import TRUST


def write_exports(
    basis: PanelBasis,
    damping_ratio: DampingRatio,
    scenarios: Sequence[ResponseScenario],
    models: Sequence[str],
    psd: xr.Dataset,
    summary: pd.DataFrame,
    title: str,
    folder: Path,
) -> None:
    """Write the files of all scenarios."""
    folder.mkdir(exist_ok=True)
    trust = summary.groupby(["reading", "scenario"])[TRUST].first()
    doubts = trust["doubts"].fillna("").to_dict()
    frequency = psd["frequency"].to_numpy()
    points = [str(name) for name in psd["point"].to_numpy()]
    curves: list[Curve] = []
    subcase = 0
    for reading in models:
        for scenario in scenarios:
            label = scenario.label
            if not is_steady(psd, reading, label):
                continue
            case = psd.sel(reading=reading, scenario=label)
            bare = psd["acceleration_psd"].sel(reading=reading, scenario=scenario.bare_label)
            subcase += 1
            series = case["acceleration_psd"], bare, case["acceleration_psd_log_error"]
            for node, point in enumerate(points, start=1):
                values, of_bare, error = (each.sel(point=point).to_numpy() for each in series)
                reason = doubts[reading, label]
                curves.append(
                    Curve(reading, label, point, node, values, of_bare, reason, error, subcase)
                )
            write_csv(
                folder / f"psd_{reading}_{label}.csv", _psd_columns(case, frequency, points), 7
            )
            if not scenario.is_bare:
                path = folder / f"dampers_{reading}_{label}.bdf"
                title_of_case = f"{title}: {reading}, {label}"
                in_patch = dict(zip(basis.patch_names, basis.cell_in_patch, strict=True))
                dampers = {name: _damping_of(case.sel(patch=name)) for name in scenario.patches}
                mesh = (basis.vertex_position, basis.cells)
                write_bushes(path, title_of_case, frequency, dampers, *mesh, in_patch)
    bands = third_octave_rows(frequency, curves)
    model_error = summary.set_index(["reading", "scenario", "point"])["model_error_db"]
    bands = bands.join(model_error, on=["reading", "scenario", "point"])
    write_csv(folder / "third_octaves.csv", bands.join(trust, on=["reading", "scenario"]))
    write_tabrnd1(folder / "tabrnd1.bdf", frequency, curves, title)
    write_uff58(folder / "psd.uff", frequency, curves, title, basis.point_position)
    modes, ratios = modal_damping(basis, damping_ratio, scenarios, models, psd)
    write_tabdmp1(folder / "tabdmp1.bdf", modes, ratios, title)


def _damping_of(case: xr.Dataset) -> tuple[Array, Array]:
    return case["equivalent_damping"].to_numpy(), case["apparent_mass"].to_numpy()


def _psd_columns(dataset: xr.Dataset, frequency: Array, points: Sequence[str]) -> pd.DataFrame:
    """Return PSDs of a scenario in the units of reports."""
    columns = {"frequency_hz": frequency}
    for point in points:
        values = dataset.sel(point=point)
        acceleration = values["acceleration_psd"].to_numpy()
        columns |= {
            f"acceleration_psd_g2_hz_{point}": acceleration / STANDARD_GRAVITY**2,
            f"acceleration_psd_error_db_{point}": 10
            / np.log(10)
            * values["acceleration_psd_log_error"].to_numpy(),
            f"velocity_psd_m2_s2_hz_{point}": values["velocity_psd"].to_numpy(),
            f"displacement_psd_mm2_hz_{point}": values["displacement_psd"].to_numpy() * 1e6,
        }
    return pd.DataFrame(columns)


def modal_damping(
    basis: PanelBasis,
    damping_ratio: DampingRatio,
    scenarios: Sequence[ResponseScenario],
    models: Sequence[str],
    psd: xr.Dataset,
) -> tuple[Array, dict[str, Array]]:
    """Return the damping ratio of every mode in every scenario that has a steady response."""
    lines = psd["frequency"].to_numpy()
    natural, ratios = basis.natural_frequency, {}
    modes = np.flatnonzero(~basis.is_residual & (natural >= lines[0]) & (natural <= lines[-1]))
    modes = modes[np.argsort(natural[modes])]
    natural, mass = natural[modes], basis.modal_mass[modes]
    for reading in models:
        for scenario in scenarios:
            if not is_steady(psd, reading, scenario.label):
                continue
            ratio = damping_ratio.of_modes(natural)
            for name in scenario.patches:
                case = {"reading": reading, "scenario": scenario.label, "patch": name}
                values = np.interp(natural, lines, psd["equivalent_damping"].sel(case).to_numpy())
                overlap = basis.patch_overlap[basis.patch_names.index(name), modes, modes]
                ratio = modal_damping_ratio(ratio, natural, mass, overlap, values)
            ratios[f"{reading}, {scenario.label}"] = ratio
    return natural, ratios
