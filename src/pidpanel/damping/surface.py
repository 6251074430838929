"""C_e(r, f, Γ) and m_a(r, f, Γ) as a table over run points, interpolated between them.

Linear in r, ln f and ln Γ; ln C_e and m_a are the interpolated quantities, since C_e follows
power laws of f and Γ over decades while m_a changes sign. Asked outside the run points the
table says so, point by point, or refuses.
"""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import NDArray
from scipy.interpolate import RegularGridInterpolator

Array = NDArray[np.float64]

AXES = ("fill_fraction", "frequency_hz", "acceleration_g")


class DampingError(ValueError):
    """A question that a law or table of damping has no answer to."""


@dataclass(frozen=True)
class DampingValues:
    """C_e, its error and m_a at the frequencies asked, and where they rest on run points.

    Attributes
    ----------
    equivalent_damping, equivalent_damping_error
        (n,) N s/m³ (per area).
    apparent_mass
        (n,) kg/m².
    inside
        (n,) False where the value is a continuation past the run points.
    """

    equivalent_damping: Array
    equivalent_damping_error: Array
    apparent_mass: Array
    inside: NDArray[np.bool_]


class DampingTable:
    """Table of C_e and m_a over fill fraction, frequency and acceleration amplitude.

    Parameters
    ----------
    fill_fraction, frequency, acceleration_g
        (a,), (b,), (c,) rising axes: –, Hz, g (amplitude of a sine).
    equivalent_damping, equivalent_damping_error, apparent_mass
        (a, b, c) N s/m³, N s/m³, kg/m²; NaN where no case stands.

    Raises
    ------
    DampingError
        If a fill and frequency has no case at all.
    """

    def __init__(
        self,
        fill_fraction: Array,
        frequency: Array,
        acceleration_g: Array,
        equivalent_damping: Array,
        equivalent_damping_error: Array,
        apparent_mass: Array,
    ) -> None:
        self.fill_fraction = np.asarray(fill_fraction, float)
        self.frequency = np.asarray(frequency, float)
        self.acceleration_g = np.asarray(acceleration_g, float)
        self.equivalent_damping = np.asarray(equivalent_damping, float)
        self.equivalent_damping_error = np.asarray(equivalent_damping_error, float)
        self.apparent_mass = np.asarray(apparent_mass, float)
        # a value within its own error of zero has no logarithm to speak of
        self.run = self.equivalent_damping > self.equivalent_damping_error
        log_damping, relative_error, mass = self._continued()
        self._log_damping = self._interpolator(log_damping)
        self._relative_error = self._interpolator(relative_error)
        self._mass = self._interpolator(mass)
        self._run = self._interpolator(self.run.astype(float))
        self.depends_on_level = len(self.acceleration_g) > 1

    def _continued(self) -> tuple[Array, Array, Array]:
        """Nodes without a case, continued along Γ from the nearest two that have one."""
        log_level = np.log(self.acceleration_g)
        with np.errstate(invalid="ignore", divide="ignore"):
            log_damping = np.where(self.run, np.log(self.equivalent_damping), np.nan)
            relative = np.where(
                self.run, self.equivalent_damping_error / self.equivalent_damping, np.nan
            )
        mass = np.where(self.run, self.apparent_mass, np.nan)
        for i, j in np.ndindex(log_damping.shape[:2]):
            have = self.run[i, j]
            if have.all():
                continue
            if not have.any():
                raise DampingError(
                    f"no case stands at fill_fraction {self.fill_fraction[i]:g}, "
                    f"frequency_hz {self.frequency[j]:g}; at least one level is needed"
                )
            x, y = log_level[have], log_damping[i, j, have]
            for k in np.flatnonzero(~have):
                if len(x) == 1:
                    log_damping[i, j, k] = y[0]
                else:
                    n = int(np.clip(np.searchsorted(x, log_level[k]), 1, len(x) - 1))
                    slope = (y[n] - y[n - 1]) / (x[n] - x[n - 1])
                    log_damping[i, j, k] = y[n] + slope * (log_level[k] - x[n])
            mass[i, j] = np.interp(log_level, x, mass[i, j, have])
            relative[i, j] = np.interp(log_level, x, relative[i, j, have])
        return log_damping, relative, mass

    def _interpolator(self, values: Array) -> RegularGridInterpolator:
        axes = [self.fill_fraction, np.log(self.frequency), np.log(self.acceleration_g)]
        for number, axis in enumerate(axes):
            if len(axis) == 1:  # constant along an axis of one value
                axes[number] = np.array([axis[0], axis[0] + 1.0])
                values = np.repeat(values, 2, axis=number)
        return RegularGridInterpolator(tuple(axes), values)

    def __call__(
        self, frequency: Array, fill_fraction: float, acceleration_g: float, outside: str = "mark"
    ) -> DampingValues:
        """C_e and m_a at ``frequency`` (n,) Hz for one fill and one amplitude Γ.

        Past the run points the nearest value is held in r and f; along Γ the value at the
        last level is held too.

        Raises
        ------
        DampingError
            With ``outside="refuse"``, if any value would be a continuation.
        """
        asked = [np.full(len(frequency), float(fill_fraction)), np.asarray(frequency, float)]
        asked.append(np.full(len(frequency), float(acceleration_g)))
        within = np.ones(len(frequency), bool)
        point = []
        for values, axis, logarithmic in zip(
            asked,
            (self.fill_fraction, self.frequency, self.acceleration_g),
            (False, True, True),
            strict=True,
        ):
            low, high = axis[0], axis[-1]
            within &= (values >= low * (1 - 1e-9)) & (values <= high * (1 + 1e-9))
            held = np.clip(values, low, high)
            point.append(np.log(held) if logarithmic else held)
        at = np.stack(point, axis=1)
        inside = within & (self._run(at) > 1 - 1e-9)
        if outside == "refuse" and not inside.all():
            worst = frequency[~inside]
            raise DampingError(
                f"acceleration_g = {acceleration_g:.3g} at fill_fraction {fill_fraction:g}, "
                f"{worst.min():g} to {worst.max():g} Hz: outside the run points "
                f"({self.acceleration_g[0]:g} to {self.acceleration_g[-1]:g} g, "
                f"{self.frequency[0]:g} to {self.frequency[-1]:g} Hz)"
            )
        damping = np.exp(self._log_damping(at))
        return DampingValues(damping, damping * self._relative_error(at), self._mass(at), inside)

    def to_dataset(self) -> xr.Dataset:
        """The table as it stands, with units, NaN where no case stands."""
        return xr.Dataset(
            {
                "equivalent_damping": (
                    AXES,
                    self.equivalent_damping,
                    {"units": "N s m-3", "long_name": "equivalent viscous damping per area, C_e"},
                ),
                "equivalent_damping_error": (
                    AXES,
                    self.equivalent_damping_error,
                    {"units": "N s m-3", "long_name": "standard error of C_e"},
                ),
                "apparent_mass": (
                    AXES,
                    self.apparent_mass,
                    {"units": "kg m-2", "long_name": "apparent mass per area, m_a"},
                ),
            },
            coords={
                "fill_fraction": (
                    "fill_fraction",
                    self.fill_fraction,
                    {"units": "1", "long_name": "fill fraction r"},
                ),
                "frequency_hz": (
                    "frequency_hz",
                    self.frequency,
                    {"units": "Hz", "long_name": "frequency"},
                ),
                "acceleration_g": (
                    "acceleration_g",
                    self.acceleration_g,
                    {"units": "g", "long_name": "acceleration amplitude Γ"},
                ),
            },
        )

    @staticmethod
    def from_dataset(dataset: xr.Dataset) -> DampingTable:
        """Inverse of `to_dataset`."""
        names = (*AXES, "equivalent_damping", "equivalent_damping_error", "apparent_mass")
        return DampingTable(*(dataset[name].to_numpy() for name in names))

    @staticmethod
    def from_frame(frame: pd.DataFrame) -> DampingTable:
        """Table from rows such as those of ``coupon/cases.csv``.

        Parameters
        ----------
        frame
            Columns ``fill_fraction``, ``frequency_hz``, ``acceleration_g``,
            ``equivalent_damping_n_s_m3``; optional ``equivalent_damping_error_n_s_m3``,
            ``apparent_mass_kg_m2`` (0 if left out) and ``status`` (only rows "ok" count).

        Raises
        ------
        DampingError
            If a column is missing or a point stands twice.
        """
        value, error, mass = (
            "equivalent_damping_n_s_m3",
            "equivalent_damping_error_n_s_m3",
            "apparent_mass_kg_m2",
        )
        for column in (*AXES, value):
            if column not in frame:
                raise DampingError(
                    f"column {column} is missing; there are {', '.join(frame.columns)}"
                )
        frame = frame.assign(**{c: 0.0 for c in (error, mass) if c not in frame})
        if frame.duplicated(list(AXES)).any():
            twice = frame[frame.duplicated(list(AXES))].iloc[0]
            raise DampingError(
                "two rows at " + ", ".join(f"{axis} = {twice[axis]:g}" for axis in AXES)
            )
        axes = [np.unique(frame[axis].to_numpy(float)) for axis in AXES]
        grids = {c: np.full([len(a) for a in axes], np.nan) for c in (value, error, mass)}
        good = frame[frame["status"] == "ok"] if "status" in frame else frame
        index = tuple(
            np.searchsorted(a, good[axis].to_numpy(float))
            for a, axis in zip(axes, AXES, strict=True)
        )
        for column, grid in grids.items():
            grid[index] = good[column].to_numpy(float)
        return DampingTable(*axes, *(grids[column] for column in (value, error, mass)))

    @staticmethod
    def from_csv(path: Path) -> DampingTable:
        """Table from a CSV file with the columns of `from_frame`; ``#`` starts a comment."""
        try:
            frame = pd.read_csv(path, comment="#")
            return DampingTable.from_frame(frame)
        except (DampingError, pd.errors.ParserError, ValueError) as error:
            raise DampingError(f"{path}: {error}") from None
