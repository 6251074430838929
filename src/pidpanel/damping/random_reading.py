"""C_e and m_a of a coupon under one random motion, as a reading of the damping."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.damping.best_linear import LinearApproximation
from pidpanel.damping.readings import DampingError, DampingValues, Point

LEAST = 0.5
"""C_e of a band that is below this many of its standard errors is taken as so many: what is
not resolved must not feed the panel."""

UNITS = {
    "low": "low_hz",
    "high": "high_hz",
    "frequency": "frequency_hz",
    "equivalent_damping": "equivalent_damping_n_s_m3",
    "equivalent_damping_error": "equivalent_damping_error_n_s_m3",
    "apparent_mass": "apparent_mass_kg_m2",
    "apparent_mass_error": "apparent_mass_error_kg_m2",
    "coherence": "coherence",
    "common_psd": "common_force_psd_pa2_hz",
    "own_psd": "own_force_psd_pa2_hz",
    "packing_error": "packing_error",
}
"""Columns of a table by the names of `LinearApproximation`."""


@dataclass(frozen=True)
class RandomReading:
    """The best linear approximation of one patch's particles under its own motion.

    Fill and Γ are not asked for: they are those of the motion.

    Attributes
    ----------
    bands
        C_e and m_a at frequencies, with errors; between them ln C_e and m_a are linear in ln f.
    weight
        Of the particles [kg/m²].
    area
        Of the coupon [m²].
    with_mass
        Whether m_a counts.
    agreed
        Whether that motion is the one which the panel then has, and known as well as is wanted.
    """

    bands: LinearApproximation
    weight: float
    area: float
    with_mass: bool = True
    agreed: bool = True
    depends_on_acceleration = False

    @property
    def nodes(self) -> Array:
        """(n,) frequencies of the bands [Hz]."""
        return self.bands.frequency

    def __call__(
        self, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> DampingValues:
        """Return C_e and m_a at ``frequency`` (n,) [Hz]; see `readings.DampingReading`."""
        frequency = np.asarray(frequency, float)
        hats = self._hats(frequency)
        damping = np.exp(hats @ np.log(self._damping))
        square = np.sum(hats * (hats @ self._log_covariance), axis=1)
        mass = hats @ self.bands.apparent_mass if self.with_mass else np.zeros(frequency.shape)
        inside = (frequency >= self.bands.low[0] * (1 - 1e-9)) & (frequency <= self.bands.high[-1])
        return DampingValues(damping, damping * np.sqrt(square), mass, inside)

    def covariance(self, frequency: Array, fill_fraction: float, acceleration_g: float) -> Array:
        """Return the covariance (2n, 2n) of ln C_e, then of m_a, at (n,) [Hz]."""
        hats = self._hats(np.asarray(frequency, float))
        count = len(hats)
        result = np.zeros((2 * count, 2 * count))
        result[:count, :count] = hats @ self._log_covariance @ hats.T
        if self.with_mass:
            result[count:, count:] = hats @ self._mass_covariance @ hats.T
        return result

    def cross_covariance(self, frequency: Array, one: Point, other: Point) -> Array:
        """Return the covariance itself: the parts of a patch have the same damper."""
        return self.covariance(frequency, *one)

    def mass_per_area(self, fill_fraction: float) -> float:
        """Return what the particles weigh [kg/m²]."""
        return self.weight

    def without_mass(self) -> RandomReading:
        """Return the same damping with m_a = 0."""
        return replace(self, with_mass=False)

    def with_packing_error(self, packing_error: float) -> RandomReading:
        """Return the same with another error of its packings [1]."""
        return replace(self, bands=replace(self.bands, packing_error=packing_error))

    @property
    def of_packings_alone(self) -> RandomReading:
        """The same with no other errors than those of few packings."""
        none = np.zeros(len(self.bands.frequency))
        bands = replace(
            self.bands,
            equivalent_damping=self._damping,
            equivalent_damping_error=none,
            apparent_mass_error=none,
        )
        return replace(self, bands=bands)

    def common_force_psd(self, frequency: Array) -> Array:
        """Return the PSD (n,) of the force that all cells of a patch share [Pa²/Hz]."""
        return self._psd(frequency, self.bands.common_psd)

    def own_force_psd(self, frequency: Array) -> Array:
        """Return the PSD (n,) of the cells' own forces, as density over area [Pa² m²/Hz].

        A patch of the area A feels that over A as the PSD of its mean.
        """
        return self._psd(frequency, self.bands.own_psd * self.area)

    @property
    def _damping(self) -> Array:
        bands = self.bands
        return np.maximum(bands.equivalent_damping, LEAST * bands.equivalent_damping_error)

    @property
    def _log_covariance(self) -> Array:
        relative = self.bands.equivalent_damping_error / self._damping
        return np.diag(relative**2) + self.bands.packing_error**2

    @property
    def _mass_covariance(self) -> Array:
        shared = self.bands.packing_error * self.bands.apparent_mass
        return np.diag(self.bands.apparent_mass_error**2) + np.outer(shared, shared)

    def _hats(self, frequency: Array) -> Array:
        """(n, n_bands) what each band counts at a frequency."""
        at = np.log(self.bands.frequency)
        return np.stack([np.interp(np.log(frequency), at, one) for one in np.eye(len(at))], axis=1)

    def _psd(self, frequency: Array, psd: Array) -> Array:
        least = max(float(psd.max()), 1e-300) * 1e-12
        found: Array = np.exp(self._hats(frequency) @ np.log(np.maximum(psd, least)))
        return found


def to_rows(reading: RandomReading, what: dict[str, Any]) -> list[dict[str, Any]]:
    """Return a row of a table for each band.

    Parameters
    ----------
    reading
        The reading.
    what
        Columns that say of which patch it is.
    """
    values = asdict(reading.bands)
    beside = {
        **what,
        "particle_mass_per_area_kg_m2": reading.weight,
        "coupon_area_m2": reading.area,
        "packing_error": values.pop("packing_error"),
        "agreed": reading.agreed,
    }
    count = len(reading.bands.frequency)
    return [
        {**beside, **{UNITS[name]: float(column[row]) for name, column in values.items()}}
        for row in range(count)
    ]


def from_rows(rows: pd.DataFrame) -> RandomReading:
    """Return the reading of the rows of one patch; the inverse of `to_rows`."""
    columns: dict[str, Any] = {name: rows[column].to_numpy(float) for name, column in UNITS.items()}
    columns["packing_error"] = float(rows["packing_error"].iloc[0])
    bands = LinearApproximation(**columns)
    return RandomReading(
        bands,
        weight=float(rows["particle_mass_per_area_kg_m2"].iloc[0]),
        area=float(rows["coupon_area_m2"].iloc[0]),
        agreed=bool(rows["agreed"].iloc[0]),
    )


def read_random(path: Path) -> dict[tuple[str, str], RandomReading]:
    """Read ``random/impedance.csv``: scenario and patch → reading.

    Raises
    ------
    DampingError
        With the file, if a column is missing.
    """
    table = pd.read_csv(path)
    missing: Sequence[str] = sorted({*UNITS.values(), "agreed"} - set(table.columns))
    if missing:
        raise DampingError(f"{path}: no column {missing[0]}")
    return {
        (str(scenario), str(patch)): from_rows(rows)
        for (scenario, patch), rows in table.groupby(["scenario", "patch"], sort=False)
    }
