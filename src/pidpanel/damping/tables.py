"""Tables of measured or foreign damping; the surface of cases as such a table.

What is given is interpolated, `interpolation`, and C_e and m_a follow from it:

    C_e                                    m_a
    C_e                                    m_a; without that column 0, or the mass of the particles
    η m″ ω                                 the same
    Re Z                                   Im Z/ω            (Z = C_e + iω m_a, e^{iωt})

with m″ the mass of the particles per area, linear in the fill. A displacement or velocity is the
axis itself: the question's Γ is Γ g/ω² or Γ g/ω on it. Nothing is known of gravity, of beds or of
a bound.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from pidpanel.arrays import Array, Flags
from pidpanel.damping import table_files
from pidpanel.damping.broadband import EXACT, SINGLE_TONES
from pidpanel.damping.interpolation import Interpolation, Interpolator
from pidpanel.damping.models import NODE_STEP, Damper, DampingValues, Point, correlated_covariance

# Largest number of nodes of the errors: the frequencies of a table, or equally spaced ones.
MOST_NODES = 40


def impedance_of(
    columns: Mapping[str, Array], omega: Array, mass_per_area: Array | float
) -> tuple[Array, Array, Array, Array]:
    """Return C_e and its standard error [N s/m³], m_a and its standard error [kg/m²], (n,) each.

    Parameters
    ----------
    columns
        (n,) the given value, with its error and m_a; 0 if the table has none.
    omega
        (n,) ω [rad/s].
    mass_per_area
        Mass of the particles per area [kg/m²], for a loss factor.
    """
    names = table_files.quantities_of(columns)
    scale = mass_per_area * omega if names[0] == table_files.LOSS_FACTOR else 1.0
    mass_scale = 1 / omega if names[2] == table_files.IMAGINARY else 1.0
    value, error, mass, mass_error = (columns.get(name, np.zeros_like(omega)) for name in names)
    return value * scale, error * scale, mass * mass_scale, mass_error * mass_scale


class TableDamping(Damper):
    """Damping model from the rows of a table.

    Parameters
    ----------
    columns
        (n,) each, as `table_files.read_columns` returns them.

    Attributes
    ----------
    nodes
        Frequencies between which errors are linear in ln f [Hz]; None where the table has none.
    """

    broadband_error = SINGLE_TONES
    nodes: Array | None = None

    def __init__(self, columns: Mapping[str, Array], interpolation: Interpolation) -> None:
        self._columns = columns
        frequency, fill = columns[table_files.FREQUENCY], table_files.fill_of(columns)
        self._amplitude, amplitude = table_files.amplitude_of(columns)
        names = table_files.quantities_of(columns)
        self._names = [name for name in names if name in columns]
        values = np.stack([columns[name] for name in self._names], axis=1)
        self._rows = Interpolator(fill, amplitude, frequency, values, interpolation)
        self.depends_on_acceleration = self._rows.depends_on_amplitude
        if self._amplitude is None:
            self.broadband_error = EXACT
        if any(columns[name].any() for name in names[1::2] if name in columns):
            self.nodes = _nodes(frequency)
        self._fills = np.unique(fill)
        if table_files.PARTICLE_MASS in columns:
            mass = columns[table_files.PARTICLE_MASS]
            self._masses = np.array([mass[fill == level][0] for level in self._fills])
        else:
            self._masses = np.full(len(self._fills), np.nan)

    def __call__(
        self, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> DampingValues:
        """Return C_e and m_a at ``frequency`` (n,) [Hz]; see `models.Damper`.

        Beyond the rows values are constant and not inside. A table of one amplitude is for all, as
        does one without fills for every fill.
        """
        values, errors, inside = self._read(frequency, fill_fraction, acceleration_g)
        n = len(errors) // 2
        return DampingValues(values[:n], errors[:n] * values[:n], values[n:], inside)

    def _read(self, frequency: Array, fill: float, gamma: float) -> tuple[Array, Array, Flags]:
        """Return C_e, then m_a (2n,); standard errors of ln C_e, then m_a (2n,); inside (n,)."""
        frequency = np.asarray(frequency, float)
        omega = 2 * np.pi * frequency
        fills = np.full(frequency.shape, fill if table_files.FILL in self._columns else 1.0)
        amplitude = np.ones_like(omega)
        if self._amplitude is not None:
            amplitude = gamma / table_files.gamma_per_unit(self._amplitude, omega)
        rows, inside = self._rows(fills, amplitude, frequency)
        named = dict(zip(self._names, rows.T, strict=True))
        damping, error, mass, mass_error = impedance_of(named, omega, self.mass_per_area(fill))
        relative = np.divide(error, damping, out=np.zeros_like(error), where=damping > 0)
        return np.concatenate([damping, mass]), np.concatenate([relative, mass_error]), inside

    def cross_covariance(self, frequency: Array, first: Point, second: Point) -> Array:
        """Return the covariance (2n, 2n) between the values at two points of r and Γ.

        A table does not state the correlation of its errors. Full correlation over the whole table
        is assumed; see `models.correlated_covariance`.
        """
        errors = (self._read(frequency, *point)[1] for point in (first, second))
        return correlated_covariance(*errors)

    def mass_per_area(self, fill_fraction: float) -> float:
        """Return the mass of the particles [kg/m²], linear in the fill; NaN where not given."""
        fill = fill_fraction if table_files.FILL in self._columns else 1.0
        return float(np.interp(fill, self._fills, self._masses))


def _nodes(frequency: Array) -> Array:
    """Return the frequencies of the rows, or equally spaced ones if there are many."""
    unique = np.unique(frequency)
    if len(unique) <= MOST_NODES:
        return unique
    return np.geomspace(unique[0], unique[-1], int(np.log(unique[-1] / unique[0]) / NODE_STEP) + 2)
