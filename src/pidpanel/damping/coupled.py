"""C_e, m_a and own force from coupled runs, as a damping model with its errors."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from pidpanel.arrays import Array
from pidpanel.damping.models import Damper, DampingValues, Point
from pidpanel.provenance.results import read_csv

COUPLED = "coupled"  # name of this damping model in a study

# Lower limit of C_e of a band in its standard errors: unresolved damping must not feed the panel.
FLOOR = 0.5

# Columns of ``coupled/impedance.csv`` by the names of `CoupledDamping`.
BAND_COLUMNS = {
    "frequency": "frequency_hz",
    "equivalent_damping": "equivalent_damping_n_s_m3",
    "equivalent_damping_error": "equivalent_damping_error_n_s_m3",
    "apparent_mass": "apparent_mass_kg_m2",
    "apparent_mass_error": "apparent_mass_error_kg_m2",
    "own_psd": "own_force_psd_pa2_hz",
    "own_coherence": "own_force_coherence",
}

# Columns with one value a patch, by the names of `CoupledDamping`.
SCALARS = {
    "own_length": "own_force_length_m_hz",
    "cell_area": "cell_area_m2",
    "weight": "particle_mass_per_area_kg_m2",
    "common_error": "common_error",
}


@dataclass(frozen=True, kw_only=True)
class CoupledDamping(Damper):
    """C_e, m_a and own force of one patch at the motion that it has.

    ln C_e, m_a, ln of the PSD of the own force and its coherence are linear in ln f between the
    bands at ``frequency`` (n,) [Hz]. Fill and Γ are not arguments: they are those of the runs.
    ``own_length`` is the coherence length times frequency [m Hz], ``cell_area`` [m²], ``weight`` of
    the particles [kg/m²].
    """

    frequency: Array
    # (n,) C_e and its standard error [N s/m³]
    equivalent_damping: Array
    equivalent_damping_error: Array
    # (n,) m_a and its standard error [kg/m²]
    apparent_mass: Array
    apparent_mass_error: Array
    # (n,) PSD of the own force of a cell [Pa²/Hz], and the coherence of two cells [1]
    own_psd: Array
    own_coherence: Array
    common_error: float = 0.0  # relative standard error of all C_e and m_a together [1]
    own_length: float
    cell_area: float
    weight: float

    @property
    def coupled(self) -> CoupledDamping:
        """The runs themselves, with the own force of the particles."""
        return self

    @property
    def resolved_damping(self) -> Array:
        """(n,) C_e, or `FLOOR` of its standard errors where it is less [N s/m³]."""
        return np.maximum(self.equivalent_damping, FLOOR * self.equivalent_damping_error)

    @property
    def nodes(self) -> Array:
        """(n,) frequencies of the bands [Hz]."""
        return self.frequency

    def __call__(
        self, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> DampingValues:
        """Return C_e and m_a at ``frequency`` (n,) [Hz]; see `models.Damper`."""
        frequency = np.asarray(frequency, float)
        hats = self._hats(frequency)
        damping = np.exp(hats @ np.log(self.resolved_damping))
        variance = np.sum(hats * (hats @ self._log_covariance), axis=1)
        inside = np.ones(frequency.shape, np.bool_)
        return DampingValues(
            damping, damping * np.sqrt(variance), hats @ self.apparent_mass, inside
        )

    def cross_covariance(self, frequency: Array, first: Point, second: Point) -> Array:
        """Return the covariance (2n, 2n) of ln C_e, then of m_a, at (n,) [Hz]."""
        hats = self._hats(np.asarray(frequency, float))
        count = len(hats)
        result = np.zeros((2 * count, 2 * count))
        result[:count, :count] = hats @ self._log_covariance @ hats.T
        common = self.common_error * self.apparent_mass
        mass = np.diag(self.apparent_mass_error**2) + np.outer(common, common)
        result[count:, count:] = hats @ mass @ hats.T
        return result

    def mass_per_area(self, fill_fraction: float) -> float:
        """Return the mass of the particles [kg/m²]."""
        return self.weight

    def own_force(self, frequency: Array) -> tuple[Array, Array]:
        """Return PSD [Pa²/Hz] and coherence [1] of the own force of a cell, (nf,) each."""
        hats = self._hats(np.asarray(frequency, float))
        psd = np.exp(hats @ np.log(np.maximum(self.own_psd, 1e-300)))
        return psd, hats @ self.own_coherence

    @property
    def _log_covariance(self) -> Array:
        independent = np.diag((self.equivalent_damping_error / self.resolved_damping) ** 2)
        return independent + self.common_error**2

    def _hats(self, frequency: Array) -> Array:
        """Return (nf, n) piecewise linear functions of ln f, 1 at one node and 0 at the others."""
        x, nodes = np.log(frequency), np.log(self.frequency)
        return np.stack([np.interp(x, nodes, unit) for unit in np.eye(len(nodes))], axis=1)


def read_coupled(path: Path) -> dict[tuple[str, str], CoupledDamping]:
    """Read ``coupled/impedance.csv``: scenario and patch → C_e, m_a and own force of its bed."""
    table = read_csv(path, dtype={"scenario": str, "patch": str})
    beds = {}
    for (scenario, patch), rows in table.groupby(["scenario", "patch"], sort=False):
        values: dict[str, Any] = {
            **{name: rows[column].to_numpy(float) for name, column in BAND_COLUMNS.items()},
            **{name: float(rows[column].iloc[0]) for name, column in SCALARS.items()},
        }
        beds[str(scenario), str(patch)] = CoupledDamping(**values)
    return beds
