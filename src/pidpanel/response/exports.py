"""Files for other programs: CSV, third octaves, Nastran tables and dampers, UFF 58.

Units are those of the PSD handed in. Nastran's TABRND1 and Universal File 58 carry none, so they
stand in titles and comments.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pyuff
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.damping_ratio import DampingRatio
from pidpanel.panel.basis import PanelBasis
from pidpanel.panel.files import in_space
from pidpanel.response.cases import ResponseScenario
from pidpanel.response.nastran import (
    LINEAR,
    large_field_table,
    modal_damping_ratio,
    write_bushes,
    write_tabdmp1,
)
from pidpanel.response.psd_files import is_steady
from pidpanel.response.results import write_csv
from pidpanel.response.trust import TRUST
from pidpanel.solve.bands import band_rms, reduction, third_octaves

# Codes of Universal File 58: function type, kind of abscissa and of ordinate.
PSD, FREQUENCY, ACCELERATION = 9, 18, 12

NORMAL_TO_PANEL = 3  # code of the direction +z

# Numbers of the data sets that describe the contents and positions of a file.
HEADER, UNITS, NODES = 151, 164, 15
SI, RELATIVE = 1, 2  # codes of the units of a universal file, and of its temperatures
NO_DATE = "01-Jan-70 00:00:00  "


SUPPORTS = "supports"  # in the place of a point, with node 0


@dataclass(frozen=True)
class Curve:
    """One acceleration PSD."""

    scenario: str
    point: str
    node: int  # number of the point, from 1
    acceleration_psd: Array  # (nf,) one-sided [(m/s²)²/Hz]
    bare_psd: Array  # (nf,) the same of the bare panel under the same excitation
    log_error: Array | None = None  # (nf,) standard error of ln of the PSD
    doubts: str = ""  # why it is not to be trusted; empty where it is
    subcase: int = 1  # number of the damping model and scenario, from 1

    @property
    def title(self) -> str:
        """Quantity of the PSD in one line."""
        caution = f" (caution: {self.doubts})" if self.doubts else ""
        return f"{self.scenario}, point {self.point}{caution}"


def write_tabrnd1(path: Path, frequency: Array, curves: Sequence[Curve], title: str) -> None:
    """Write bulk data cards TABRND1, large field, linear in both axes, in (m/s²)²/Hz.

    Lines of the response are close enough for straight lines between them, which is what the
    rms values here are integrals of. Tables are numbered from 1 in the order given; comments name
    subcase and grid, the node of `write_uff58`.
    """
    with path.open("w", encoding="ascii", errors="replace") as file:
        file.write(f"$ {title}\n$ one-sided acceleration PSD, (m/s**2)**2/Hz over Hz\n")
        for number, curve in enumerate(curves, start=1):
            where = f"subcase {curve.subcase}, grid {curve.node}, component 3"
            file.write(f"$ {where}: {curve.title}\n")
            psd = curve.acceleration_psd
            file.writelines(large_field_table("TABRND1", number, LINEAR, frequency, psd))


def write_uff58(
    path: Path, frequency: Array, curves: Sequence[Curve], title: str, position: Array
) -> None:
    """Write a universal file: header, SI units, points, then a data set 58 for each curve.

    Data sets 151, 164 and 15 describe the contents and positions. 58 is binary, in double
    precision: in ASCII a frequency has six digits, by which lines at a step would be alike.

    Parameters
    ----------
    path
        File that ends in ``.uff``.
    frequency, curves, title
        Same as in `write_tabrnd1`.
    position
        (n_points, 2) of the points, in the order of their nodes [m].
    """
    sets = [
        pyuff.prepare_58(
            binary=1,
            id1=curve.title[:80],
            id2=title[:80],
            id3="one-sided acceleration PSD, (m/s**2)**2/Hz",
            func_type=PSD,
            rsp_ent_name=curve.point[:10],
            rsp_node=curve.node,
            rsp_dir=NORMAL_TO_PANEL,
            ref_node=0,
            ref_dir=0,
            abscissa_spec_data_type=FREQUENCY,
            abscissa_axis_units_lab="Hz",
            ordinate_spec_data_type=ACCELERATION,
            ordinate_axis_units_lab="(m/s**2)**2/Hz",
            orddenom_spec_data_type=0,
            x=frequency,
            data=curve.acceleration_psd,
        )
        for curve in curves
    ]
    path.write_text(_universal_head(title, position), encoding="ascii", errors="replace")
    pyuff.UFF(str(path)).write_sets(sets, mode="add")


def _universal_head(title: str, position: Array) -> str:
    """Return data sets 151, 164 and 15, without the clock: a result depends on its inputs alone."""
    one, zero = (f"{value:25.17E}".replace("E", "D") for value in (1.0, 0.0))
    rows = {
        HEADER: [
            title[:80],
            title[:80],
            "pidpanel",
            f"{NO_DATE}{0:10}{0:10}{0:10}",
            NO_DATE,
            "pidpanel",
            NO_DATE,
        ],
        UNITS: [f"{SI:10}{'SI: metre (newton)':<20}{RELATIVE:10}", one * 3, zero],
        NODES: [
            f"{node:10}{0:10}{0:10}{0:10}{x:13.5E}{y:13.5E}{z:13.5E}"
            for node, (x, y, z) in enumerate(in_space(position).tolist(), start=1)
        ],
    }
    lines = [["    -1", f"{kind:6}", *records, "    -1"] for kind, records in rows.items()]
    return "".join(f"{line}\n" for records in lines for line in records)


def third_octave_rows(frequency: Array, curves: Sequence[Curve]) -> pd.DataFrame:
    """Return rms and mean PSD of every curve in third octaves, with the reduction against bare."""
    center, edge = third_octaves(frequency[0], frequency[-1])
    width = np.diff(edge, axis=1)[:, 0]
    frames = []
    for curve in curves:
        rms = band_rms(frequency, curve.acceleration_psd, edge)
        error = np.full_like(rms, np.nan)
        if curve.log_error is not None:  # fully correlated over the lines
            error = band_rms(frequency, curve.acceleration_psd * curve.log_error, edge) ** 2
            error = np.divide(error, 2 * rms, out=np.zeros_like(rms), where=rms > 0)
        bare_rms = band_rms(frequency, curve.bare_psd, edge)
        columns = {
            "scenario": curve.scenario,
            "point": curve.point,
            "center_hz": center,
            "lower_hz": edge[:, 0],
            "upper_hz": edge[:, 1],
            "acceleration_rms_g": rms / STANDARD_GRAVITY,
            "acceleration_rms_error_g": error / STANDARD_GRAVITY,
            "mean_acceleration_psd_g2_hz": (rms / STANDARD_GRAVITY) ** 2 / width,
            "reduction_db": reduction(bare_rms, rms),
        }
        frames.append(pd.DataFrame(columns))
    return pd.concat(frames, ignore_index=True)


def write_exports(
    basis: PanelBasis,
    damping_ratio: DampingRatio,
    scenarios: Sequence[ResponseScenario],
    psd: xr.Dataset,
    summary: pd.DataFrame,
    title: str,
    folder: Path,
) -> None:
    """Write the files of all scenarios."""
    folder.mkdir(exist_ok=True)
    trust = summary.groupby("scenario")[TRUST].first()
    doubts = trust["doubts"].fillna("").to_dict()
    frequency = psd["frequency"].to_numpy()
    points = [str(name) for name in psd["point"].to_numpy()]
    curves: list[Curve] = []
    subcase = 0
    for scenario in scenarios:
        label = scenario.label
        if not is_steady(psd, label):
            continue
        case, bare = psd.sel(scenario=label), psd.sel(scenario=scenario.bare_label)
        subcase += 1
        psds = [values["acceleration_psd"] for values in (case, bare)]
        series = [*psds, case["acceleration_psd_log_error"]]
        curves += _curves(label, points, series, doubts[label], subcase)
        write_csv(folder / f"psd_{label}.csv", _psd_columns(case, frequency, points), 7)
        if not scenario.is_bare and basis.quadrature_normal is None:  # bushes along z
            in_patch = dict(zip(basis.patch_names, basis.cell_in_patch, strict=True))
            damping, mass = case["equivalent_damping"], case["apparent_mass"]
            dampers = {
                name: (damping.sel(patch=name).to_numpy(), mass.sel(patch=name).to_numpy())
                for name in scenario.patches
            }
            path, mesh = folder / f"dampers_{label}.bdf", (basis.vertex_position, basis.cells)
            write_bushes(path, f"{title}: {label}", frequency, dampers, *mesh, in_patch)
    bands = _write_curves(frequency, curves, title, basis.point_position, folder)
    model_error = summary.set_index(["scenario", "point"])["model_error_db"]
    bands = bands.join(model_error, on=["scenario", "point"])
    write_csv(folder / "third_octaves.csv", bands.join(trust, on="scenario"))
    modes, ratios = modal_damping(basis, damping_ratio, scenarios, psd)
    write_tabdmp1(folder / "tabdmp1.bdf", modes, ratios, title)


def write_base_exports(
    psd: xr.Dataset, summary: pd.DataFrame, title: str, position: Array, folder: Path
) -> None:
    """Write the PSDs of all scenarios under random motion of the supports, and of that motion.

    Parameters
    ----------
    psd, summary
        Content of ``base/psd.nc`` and ``base/summary.csv``.
    position
        (n_points, 2) of the points [m].
    """
    folder.mkdir(exist_ok=True)
    reasons = summary.groupby(["scenario", "input"])["doubts"].first().fillna("")
    doubts: dict[tuple[str, str], str] = dict(zip(reasons.index.tolist(), reasons, strict=True))
    frequency, points = psd["frequency"].to_numpy(), psd["point"].to_numpy().tolist()
    curves: list[Curve] = []
    for subcase, (label, motion) in enumerate(doubts, start=1):
        case = psd.sel(scenario=label, input=motion)
        if case["absolute_acceleration_psd"].isnull().any():
            continue
        bare = psd.isel(scenario=0).sel(input=motion)
        name = label if motion == "stated" else f"{label}, {motion}"
        source = case["input_psd"].to_numpy()
        curves.append(Curve(name, SUPPORTS, 0, source, source, subcase=subcase))
        psds = [values["absolute_acceleration_psd"] for values in (case, bare)]
        series = [*psds, case["log_error"]]
        curves += _curves(name, points, series, doubts[label, motion], subcase)
    bands = _write_curves(frequency, curves, title, position, folder)
    write_csv(folder / "third_octaves.csv", bands)


def _curves(
    name: str, points: Sequence[str], series: Sequence[xr.DataArray], doubts: str, subcase: int
) -> list[Curve]:
    """Return the curves of a case at the points: its PSD, that of the bare panel, and the error."""
    curves = []
    for node, point in enumerate(points, start=1):
        psd, bare, error = (data.sel(point=point).to_numpy() for data in series)
        curves.append(Curve(name, point, node, psd, bare, error, doubts, subcase))
    return curves


def _write_curves(
    frequency: Array, curves: Sequence[Curve], title: str, position: Array, folder: Path
) -> pd.DataFrame:
    """Write curves as TABRND1 and UFF 58, and return their third octaves."""
    write_tabrnd1(folder / "tabrnd1.bdf", frequency, curves, title)
    write_uff58(folder / "psd.uff", frequency, curves, title, position)
    return third_octave_rows(frequency, curves)


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
    psd: xr.Dataset,
) -> tuple[Array, dict[str, Array]]:
    """Return the damping ratio of every mode in every scenario that has a steady response."""
    lines = psd["frequency"].to_numpy()
    natural, ratios = basis.natural_frequency, {}
    modes = np.flatnonzero(~basis.is_residual & (natural >= lines[0]) & (natural <= lines[-1]))
    modes = modes[np.argsort(natural[modes])]
    natural, mass = natural[modes], basis.modal_mass[modes]
    for scenario in scenarios:
        if not is_steady(psd, scenario.label):
            continue
        ratio = damping_ratio.of_modes(natural)
        for name in scenario.patches:
            case = {"scenario": scenario.label, "patch": name}
            values = np.interp(natural, lines, psd["equivalent_damping"].sel(case).to_numpy())
            overlap = basis.patch_overlap[basis.patch_names.index(name), modes, modes]
            ratio = modal_damping_ratio(ratio, natural, mass, overlap, values)
        ratios[scenario.label] = ratio
    return natural, ratios
