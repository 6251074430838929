"""Responses in the formats of other programs: Nastran TABRND1 and Universal File 58.

Units are those of the given PSD; the formats have none, so they are in titles and comments.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import pyuff

from pidpanel.arrays import Array
from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.response.nastran import large_field_table
from pidpanel.solve.bands import band_rms, reduction, third_octaves

# Codes of Universal File 58: function type, kind of abscissa and of ordinate.
PSD, FREQUENCY, ACCELERATION = 9, 18, 12

NORMAL_TO_PANEL = 3  # code of the direction +z

# Numbers of the data sets that describe the contents and positions of a file.
HEADER, UNITS, NODES = 151, 164, 15
SI, RELATIVE = 1, 2  # codes of the units of a universal file, and of its temperatures
NO_DATE = "01-Jan-70 00:00:00  "


@dataclass(frozen=True)
class Curve:
    """One acceleration PSD."""

    reading: str
    scenario: str
    point: str
    node: int  # number of the point, from 1
    acceleration_psd: Array  # (nf,) one-sided [(m/s²)²/Hz]
    bare_psd: Array  # (nf,) the same of the bare panel under the same excitation
    doubts: str = ""  # why it is not to be trusted; empty where it is
    log_error: Array | None = None  # (nf,) standard error of ln of the PSD
    subcase: int = 1  # number of the damping model and scenario, from 1

    @property
    def title(self) -> str:
        """Quantity of the PSD in one line."""
        caution = f" (caution: {self.doubts})" if self.doubts else ""
        return f"{self.reading}, {self.scenario}, point {self.point}{caution}"


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
            axes = ("LINEAR", "LINEAR")
            file.writelines(
                large_field_table("TABRND1", number, axes, frequency, curve.acceleration_psd)
            )


def write_uff58(
    path: Path, frequency: Array, curves: Sequence[Curve], title: str, position: Array
) -> None:
    """Write a universal file: header, SI units, points, then a data set 58 for each curve.

    Data sets 151, 164 and 15 describe the contents and positions. 58 is in ASCII, in double
    precision.

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
            id1=curve.title[:80],
            id2=title[:80],
            id3="one-sided acceleration PSD, (m/s**2)**2/Hz",
            func_type=PSD,
            rsp_ent_name=curve.point[:10],
            rsp_node=curve.node,
            rsp_dir=NORMAL_TO_PANEL,
            ref_node=0,
            ref_dir=0,
            abscissa_spacing=0,
            abscissa_spec_data_type=FREQUENCY,
            abscissa_axis_units_lab="Hz",
            ordinate_spec_data_type=ACCELERATION,
            ordinate_axis_units_lab="(m/s**2)**2/Hz",
            orddenom_spec_data_type=0,
            z_axis_spec_data_type=0,
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
            f"{node:10}{0:10}{0:10}{0:10}{x:13.5E}{y:13.5E}{0:13.5E}"
            for node, (x, y) in enumerate(position.tolist(), start=1)
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
        of_bare = band_rms(frequency, curve.bare_psd, edge)
        columns = {
            "reading": curve.reading,
            "scenario": curve.scenario,
            "point": curve.point,
            "center_hz": center,
            "lower_hz": edge[:, 0],
            "upper_hz": edge[:, 1],
            "acceleration_rms_g": rms / STANDARD_GRAVITY,
            "acceleration_rms_error_g": error / STANDARD_GRAVITY,
            "mean_acceleration_psd_g2_hz": (rms / STANDARD_GRAVITY) ** 2 / width,
            "reduction_db": reduction(of_bare, rms),
        }
        frames.append(pd.DataFrame(columns))
    return pd.concat(frames, ignore_index=True)
