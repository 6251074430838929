"""Rows of a case in the tables of the stage.

``where`` are the damping model and the label of its scenario.
"""

import itertools
import math
import re
from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple, Self

import numpy as np
import pandas as pd
import xarray as xr

from pidpanel.arrays import Array
from pidpanel.severity.fatigue import FatigueLine, dirlik_damage_rate, narrow_band_damage_rate
from pidpanel.severity.kurtosis import transformed
from pidpanel.severity.moments import peak_factor, spectral_moment, zero_crossing_rate
from pidpanel.severity.strength import (
    LayerStrength,
    core_index,
    maximum_stress_index,
    tsai_wu_index,
)
from pidpanel.solve.stress import CORE_STRESSES

STRESSES = ("stress_xx", "stress_yy", "stress_xy", "von_mises")
CORE = "core"
PLACE = ("scenario", "point")  # first columns of every table, which identify a row


class Bursts(NamedTuple):
    """How far accelerations at the points are from Gaussian ones; 0 where nothing is known."""

    kurtosis: Array  # (n_points,) excess [1]
    kurtosis_error: Array  # standard error
    # (n_points,) ln of the damage over that of a Gaussian motion, at the exponent of the S-N line
    damage: Array
    damage_error: Array

    @classmethod
    def none(cls, count: int) -> Self:
        """Return those of Gaussian motions."""
        return cls(*np.zeros((4, count)))

    @classmethod
    def recorded(cls, rows: pd.DataFrame, exponent: float) -> Self:
        """Return those of points in ``coupled/summary.csv``.

        ln of the damage is interpolated over b(b − 2), with which it goes for few bursts, and
        counts from 0 up.
        """
        names = [name for name in rows if re.fullmatch(r"log_damage_\d+", str(name))]
        known = np.array([float(str(name).rpartition("_")[2]) for name in names])
        scale = exponent * max(exponent - 2, 0.0)
        parts = []
        for columns in (names, [str(name).replace("damage_", "damage_error_") for name in names]):
            share = rows[columns].to_numpy(float) / (known * (known - 2))
            parts.append(scale * np.array([np.interp(exponent, known, row) for row in share]))
        value, error = (rows[f"excess_kurtosis{end}"].to_numpy() for end in ("", "_error"))
        return cls(value, error, np.maximum(parts[0], 0), parts[1])


class PointMotion(NamedTuple):
    """Motion of the points in a case."""

    where: dict[str, str]
    points: list[str]
    frequency: Array  # (nf,) [Hz]
    psd: Array  # (nf, n_points) [g²/Hz]
    error: Array  # (n_points,) of the rms, relative
    bursts: Bursts


def peak_rows(motion: PointMotion, duration: float) -> Iterator[dict[str, Any]]:
    """Yield a row per point that moves."""
    where, points, frequency, psd, error, bursts = motion
    rate = zero_crossing_rate(frequency, psd)
    gaussian = peak_factor(rate, duration)
    value, spread = bursts.kurtosis, bursts.kurtosis_error
    factor = transformed(gaussian, value)
    factor_error = (
        transformed(gaussian, value + spread) - transformed(gaussian, value - spread)
    ) / 2
    rms = np.sqrt(spectral_moment(frequency, psd, 0))
    for index, point in enumerate(points):
        if rms[index] > 0:
            yield {
                **where,
                "point": point,
                "acceleration_rms_g": rms[index],
                "three_sigma_g": 3 * rms[index],
                "zero_crossings_hz": rate[index],
                "peak_g": factor[index] * rms[index],
                "peak_error_g": rms[index] * np.hypot(factor * error, factor_error)[index],
                "excess_kurtosis": value[index],
                "excess_kurtosis_error": spread[index],
            }


FATIGUE_COLUMNS = (
    *PLACE, "layer", "quantity", "stress_rms_mpa", "zero_crossings_hz", "damage_dirlik",
    "damage_narrow_band", "damage_log_error",
)  # fmt: skip


def fatigue_rows(
    where: dict[str, str],
    stress: xr.Dataset,
    frequency: Array,
    relative_error: pd.Series,
    line: FatigueLine,
    duration: float,
    bursts: Bursts,
) -> Iterator[tuple[Any, ...]]:
    """Yield a row of fatigue damage per point, layer and stress.

    Parameters
    ----------
    where
        Values of `PLACE` for the case, without the point.
    stress, frequency
        PSDs of the case in ``response/stress.nc`` [Pa²/Hz], and their lines (nf,) [Hz].
    relative_error
        Relative errors of the rms stresses, by point, layer and quantity [1].
    line, duration
        S-N line of the material, and time of exposure [s].
    bursts
        Those of the accelerations, which the stresses at the points are taken to have.
    """
    points, layers = (stress[axis].to_numpy().astype(str).tolist() for axis in ("point", "layer"))
    for quantity in STRESSES:
        psd = stress[f"{quantity}_psd"].transpose("frequency", "point", "layer").to_numpy()
        rms = np.sqrt(spectral_moment(frequency, psd, 0)) / 1e6
        rate = zero_crossing_rate(frequency, psd)
        dirlik = dirlik_damage_rate(frequency, psd, line)
        narrow_band = narrow_band_damage_rate(frequency, psd, line)
        for (p, point), (n, layer) in itertools.product(enumerate(points), enumerate(layers)):
            if rms[p, n] > 0:
                values = (rms, rate, dirlik, narrow_band)
                numbers = [float(value[p, n]) for value in values]
                numbers[2:] = [duration * math.exp(bursts.damage[p]) * rate for rate in numbers[2:]]
                error = line.exponent * math.log1p(relative_error[point, layer, quantity])
                error = math.hypot(error, bursts.damage_error[p])
                yield (*where.values(), point, layer, quantity, *numbers, error)


STRENGTH_COLUMNS = (
    *PLACE, "layer", "maximum_stress_index", "tsai_wu_index", "relative_error",
)  # fmt: skip


def strength_rows(
    where: dict[str, str],
    stress: pd.DataFrame,
    layers: LayerStrength | None,
    core: tuple[float, float] | None,
) -> Iterator[tuple[Any, ...]]:
    """Yield a row per point and layer with a strength [MPa], of stresses of 3σ.

    ``stress`` has the rows of the case in ``response/stress.csv``, by point, layer and quantity.
    """
    for (point, layer), rows in stress.groupby(level=["point", "layer"], sort=False):
        names = list(CORE_STRESSES if layer == CORE else STRESSES[:3])
        layer_rows = rows.droplevel(["point", "layer"]).loc[names]
        amplitudes = layer_rows["three_sigma"].to_numpy()
        if layer == CORE and core is not None:
            indices = (float(core_index(amplitudes, core)), math.nan)
        elif layer != CORE and layers is not None:
            maximum = float(maximum_stress_index(amplitudes, layers))
            indices = (maximum, float(tsai_wu_index(amplitudes, layers)))
        else:
            continue
        yield (*where.values(), point, layer, *indices, layer_rows["relative_error"].max())


def index_maps(
    maps: xr.Dataset, layers: LayerStrength | None, core: tuple[float, float] | None
) -> xr.Dataset:
    """Return maps of the failure indices of stresses of 3σ from ``response/maps.nc``."""

    def amplitudes(names: Sequence[str]) -> Array:
        return 3e-6 * np.stack([maps[f"{name}_rms"].to_numpy() for name in names], axis=-1)

    indices = maps[["vertex_position", "cells"]].assign_coords(maps.coords)
    text = {"units": "1"}
    if layers is not None:
        stress, dims = amplitudes(STRESSES[:3]), ("case", "layer", "vertex")
        maximum, wu = maximum_stress_index(stress, layers), tsai_wu_index(stress, layers)
        indices["maximum_stress_index"] = (dims, maximum, text)
        indices["tsai_wu_index"] = (dims, wu, text)
    if core is not None:
        stress = amplitudes(CORE_STRESSES)
        indices["core_index"] = (("case", "vertex"), core_index(stress, core), text)
    return indices


COLUMNS = {"fatigue": FATIGUE_COLUMNS, "strength": STRENGTH_COLUMNS}
