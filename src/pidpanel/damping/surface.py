"""C_e(r, f, Γ) and m_a(r, f, Γ) from cases with errors: smooth, positive, with a standard error.

With W the amplitude of the motion and L the clear gap above the bed, both are written in the
dimensionless groups of hard spheres in a box under gravity, r, Γ and W/L ∝ Γ/(f²(1 − r)):

    C_e = r f h exp g_C(r, ln Γ, ln W/L),      m_a = r [h g_m(r, ln Γ, ln W/L) + (1 − h) m₁],
    h = 1 − (Γ₀/Γ)² above the onset Γ₀, 0 below,

where m₁ is the mass of the particles per area and fill fraction, and h is the share of its largest
kinetic energy ½ m (ωW)² with which a bed leaves the floor, at the phase sin ωt = Γ₀/Γ: below the
onset the bed rides along, with all its mass and without dissipation. g_C and g_m are Gaussian
processes (`gaussian_process`). C_e is cut at the bound 4 m₁ r ω/π of an inelastic bed, or at the
share of it that the cases themselves reach (a single elastic sphere can exceed it).

Chosen by leaving out one case after the other, 83 cases of the paper's study (5 fills, 5
frequencies, 4 accelerations; rms and largest error of ln C_e):

======================================================  =====  =======
trilinear in r, ln f, ln Γ, continued along Γ           1.467   3.91
scipy RBFInterpolator, its best, ln C_e in r, ln f, ln Γ  0.607   2.08
the same, ln C_e/(r f) in r, ln Γ, ln W/L               0.535   2.06
Gaussian process, ln C_e/(r f) in r, ln f, ln Γ         0.461   2.03
scikit-learn, this form (37 MB, fit 1.9 s, import 5 s)  0.373   1.57
this module (fit 0.07 s)                                0.309   1.22
======================================================  =====  =======

Predicted standard errors are right: errors over them have an rms of 0.94, 95 % lie within 1.96.
With 86 cases this module has 0.319 and 1.41, with 0.95 and 95 % for its standard errors.
What remains is the jump of C_e by ten where the stroke comes near the gap (80 Hz, 120 g).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import pandas as pd
import xarray as xr
from numpy.typing import ArrayLike
from scipy.spatial import ConvexHull

from pidpanel.arrays import Array, Flags
from pidpanel.damping import gaussian_process
from pidpanel.damping.gaussian_process import GaussianProcess
from pidpanel.damping.readings import DampingError, DampingValues, Point

AXES = ("fill_fraction", "frequency_hz", "acceleration_g")
VALUE, ERROR = "equivalent_damping_n_s_m3", "equivalent_damping_error_n_s_m3"
MASS, MASS_ERROR = "apparent_mass_kg_m2", "apparent_mass_error_kg_m2"
PARTICLE_MASS = "particle_mass_per_area_kg_m2"

MOST_CASES = 2000
"""The fit takes memory with the square and time with the cube of the number of cases."""

LEAST_GAP = 0.02
"""Of the depth: the clear gap of a cell that is full."""

FREQUENCY_STEP = 0.04
ACCELERATION_STEP = 0.05
"""Steps of ln f and ln Γ between the values that are computed, with linear interpolation between
them: ln C_e within 3e-3 in the paper's study, a tenth of its standard error."""


NODE_STEP = 0.17
"""Of ln f, between the nodes of the covariance; a quarter octave."""


def onset(acceleration_g: ArrayLike, onset_g: float) -> Array:
    """h = 1 − (Γ₀/Γ)² above the onset, 0 below.

    Examples
    --------
    >>> onset([0.5, 1.0, 2.0], 1.0)
    array([0.  , 0.  , 0.75])
    """
    ratio = onset_g / np.asarray(acceleration_g, float)
    return np.asarray(np.maximum(1 - ratio**2, 0.0))


def groups(fill_fraction: Array, frequency: Array, acceleration_g: Array) -> Array:
    """(n, 3) of r, ln Γ and ln(W/L) but for a constant."""
    gap = np.maximum(1 - fill_fraction, LEAST_GAP)
    gamma = np.log(acceleration_g)
    return np.stack([fill_fraction, gamma, gamma - 2 * np.log(frequency) - np.log(gap)], axis=1)


class DampingSurface:
    """C_e and m_a over fill fraction, frequency and acceleration amplitude.

    Parameters
    ----------
    cases
        The rows that count, with the columns of `AXES`, `VALUE`, `ERROR`, `MASS`, `MASS_ERROR`.
    onset_g
        Γ₀, gravity over g: Γ below which the bed does not leave the floor.
    mass_per_fill
        m₁ [kg/m²]; NaN where it is not known: then there is no bound, and m_a vanishes below the
        onset.
    damping, mass
        g_C and g_m; None for g_m = 0 everywhere.
    with_mass
        Whether the particles have an apparent mass; see `without_mass`.
    """

    def __init__(
        self,
        cases: pd.DataFrame,
        onset_g: float,
        mass_per_fill: float,
        damping: GaussianProcess,
        mass: GaussianProcess | None,
        *,
        with_mass: bool = True,
    ) -> None:
        self.cases = cases
        self.onset_g = onset_g
        self.mass_per_fill = mass_per_fill
        self.damping = damping
        self.mass = mass if with_mass else None
        known = with_mass and np.isfinite(mass_per_fill)
        self._rest_mass = mass_per_fill if known else 0.0
        axes = cases[list(AXES)].to_numpy(float)
        self.low, self.high = axes.min(axis=0), axes.max(axis=0)
        self.depends_on_acceleration = bool(self.high[2] > self.low[2])
        self._facets = _facets(_logarithmic(axes))
        share = cases[VALUE].to_numpy() / (axes[:, 0] * axes[:, 1])
        self.bound = max(8 * mass_per_fill, float(share.max()))  # 4 ω/π = 8 f
        if not np.isfinite(mass_per_fill):
            self.bound = np.inf
        nodes = np.log(self.low[1:]), np.log(self.high[1:])
        self._log_frequency = _even(nodes[0][0], nodes[1][0], FREQUENCY_STEP)
        self._log_acceleration = _even(nodes[0][1], nodes[1][1], ACCELERATION_STEP)
        self._slices: dict[float, tuple[Array, Array, Array]] = {}

    def at(
        self, fill_fraction: ArrayLike, frequency: ArrayLike, acceleration_g: ArrayLike
    ) -> DampingValues:
        """Return C_e and m_a at points (n,) of r, f [Hz] and Γ.

        Beyond the lowest and highest r, f and Γ of the cases g_C and g_m are held; below the
        lowest Γ, h continues towards the onset. Inside is the convex hull of the cases in r, ln f
        and ln Γ.
        """
        asked = np.stack(
            np.broadcast_arrays(
                *(np.asarray(a, float) for a in (fill_fraction, frequency, acceleration_g))
            ),
            axis=1,
        )
        held = np.clip(asked, self.low, self.high)
        point = groups(*held.T)
        log_damping = self.damping.mean(point)
        relative = self.damping.standard_error(point)
        share = np.zeros(len(asked)) if self.mass is None else self.mass.mean(point)
        return self._values(held[:, 0], held[:, 1], asked[:, 2], log_damping, relative, share,
                            self.inside(asked))  # fmt: skip

    def _values(
        self, fill: Array, frequency: Array, gamma: Array, log_damping: Array, relative: Array,
        share: Array, inside: Flags,
    ) -> DampingValues:  # fmt: skip
        h = onset(gamma, self.onset_g)
        most = self.bound * fill * frequency
        damping = np.minimum(h * fill * frequency * np.exp(log_damping), most)
        mass = fill * (h * share + (1 - h) * self._rest_mass)
        return DampingValues(damping, damping * relative, mass, inside)

    def mass_per_area(self, fill_fraction: float) -> float:
        """Return the mass of the particles [kg/m²], m₁ r; NaN where m₁ is not known."""
        return self.mass_per_fill * fill_fraction

    def without_mass(self) -> DampingSurface:
        """Return the same damping with m_a = 0, known exactly."""
        return DampingSurface(
            self.cases,
            self.onset_g,
            self.mass_per_fill,
            self.damping,
            None,
            with_mass=False,
        )

    def inside(self, points: Array) -> Flags:
        """Return (n,) whether points (n, 3) of r, f, Γ are in the convex hull of the cases."""
        within = np.all(
            (points >= self.low * (1 - 1e-9)) & (points <= self.high * (1 + 1e-9)), axis=1
        )
        spread, normals, offsets = self._facets
        away = _logarithmic(points)[:, spread] @ normals.T + offsets
        result: Flags = within & (away <= 1e-6).all(axis=1)
        return result

    def __call__(
        self, frequency: Array, fill_fraction: float, acceleration_g: float, outside: str = "mark"
    ) -> DampingValues:
        """Return C_e and m_a at ``frequency`` (n,) [Hz] for one fill and one amplitude Γ.

        Read from values computed once for each fill (`FREQUENCY_STEP`), since the search for the
        motion asks thousands of times. A surface of cases of one Γ answers with that Γ.

        Raises
        ------
        DampingError
            With ``outside="refuse"``, if any value would be a continuation.
        """
        frequency = np.asarray(frequency, float)
        gamma = float(acceleration_g) if self.depends_on_acceleration else float(self.low[2])
        log_acceleration = np.clip(
            np.log(gamma), self._log_acceleration[0], self._log_acceleration[-1]
        )
        row = min(
            int(np.searchsorted(self._log_acceleration, log_acceleration, "right")) - 1,
            len(self._log_acceleration) - 2,
        )
        weight = (log_acceleration - self._log_acceleration[row]) / (
            self._log_acceleration[row + 1] - self._log_acceleration[row]
        )
        held = np.clip(frequency, self.low[1], self.high[1])
        log_damping, relative, share = (
            np.interp(
                np.log(held),
                self._log_frequency,
                (1 - weight) * values[row] + weight * values[row + 1],
            )
            for values in self._slice(float(fill_fraction))
        )
        fill = np.clip(np.full(len(frequency), float(fill_fraction)), self.low[0], self.high[0])
        inside = self.inside(
            np.stack([np.full(len(frequency), float(fill_fraction)), frequency,
                      np.full(len(frequency), gamma)], axis=1)
        )  # fmt: skip
        if outside == "refuse" and not inside.all():
            worst = frequency[~inside]
            raise DampingError(
                f"acceleration_g = {gamma:.3g} at fill_fraction {fill_fraction:g}, "
                f"{worst.min():g} to {worst.max():g} Hz: outside the simulated range ("
                + ", ".join(
                    f"{axis} {low:g} to {high:g}"
                    for axis, low, high in zip(AXES, self.low, self.high, strict=True)
                )
                + ", within the convex hull of the cases)"
            )
        return self._values(
            fill, held, np.full(len(frequency), gamma), log_damping, relative, share, inside
        )

    def _slice(self, fill: float) -> tuple[Array, Array, Array]:
        """g_C, its standard error and g_m over (ln Γ, ln f) at one fill."""
        if fill not in self._slices:
            gamma, frequency = np.meshgrid(
                self._log_acceleration, self._log_frequency, indexing="ij"
            )
            held = np.full(gamma.size, np.clip(fill, self.low[0], self.high[0]))
            point = groups(held, np.exp(frequency.ravel()), np.exp(gamma.ravel()))
            share = np.zeros(gamma.size) if self.mass is None else self.mass.mean(point)
            values = (self.damping.mean(point), self.damping.standard_error(point), share)
            self._slices[fill] = tuple(v.reshape(gamma.shape) for v in values)  # type: ignore[assignment]
        return self._slices[fill]

    @property
    def nodes(self) -> Array:
        """(n,) nodes of the covariance [Hz], even in ln f; between them it is nearly linear."""
        return np.exp(_even(np.log(self.low[1]), np.log(self.high[1]), NODE_STEP))

    def covariance(self, frequency: Array, fill_fraction: float, acceleration_g: float) -> Array:
        """Return the covariance (2n, 2n) of ln C_e, then of m_a [kg/m²], at frequencies (n,) [Hz].

        The two are independent of each other.
        """
        point = (fill_fraction, acceleration_g)
        return self.cross_covariance(frequency, point, point)

    def cross_covariance(self, frequency: Array, one: Point, other: Point) -> Array:
        """Return the covariance (2n, 2n) between what is read at two points of r and Γ.

        Two patches filled with the same particles err alike where their fills and motions are
        alike. Rows are ln C_e, then m_a [kg/m²], at the first point, columns at the other.
        """
        first, scale = self._held(frequency, *one)
        second, other_scale = self._held(frequency, *other)
        n = len(frequency)
        result = np.zeros((2 * n, 2 * n))
        result[:n, :n] = self.damping.covariance(first, second)
        if self.mass is not None:
            result[n:, n:] = scale * other_scale * self.mass.covariance(first, second)
        return result

    def covariance_with(
        self, cases: Array, frequency: Array, fill_fraction: float, acceleration_g: float
    ) -> tuple[Array, Array]:
        """Return what a further case at ``cases`` (k, 3) of r, f, Γ would tell of the surface.

        Returns
        -------
        cross
            (2n, k) covariance of ln C_e, then of m_a, at ``frequency`` (n,) [Hz] with the g_C or
            g_m of the case.
        variance
            (2, k) of g_C and g_m at the case.
        """
        point, scale = self._held(frequency, fill_fraction, acceleration_g)
        at, n = groups(*cases.T), len(frequency)
        cross, variance = np.zeros((2 * n, len(at))), np.zeros((2, len(at)))
        cross[:n], variance[0] = (
            self.damping.covariance(point, at), self.damping.standard_error(at) ** 2
        )  # fmt: skip
        if self.mass is not None:
            cross[n:], variance[1] = (
                scale * self.mass.covariance(point, at), self.mass.standard_error(at) ** 2
            )  # fmt: skip
        return cross, variance

    def _held(self, frequency: Array, fill: float, gamma: float) -> tuple[Array, float]:
        """Return the groups of points held within the cases, and m_a per g_m there."""
        if not self.depends_on_acceleration:
            gamma = float(self.low[2])
        asked = np.stack([np.full(len(frequency), fill), frequency,
                          np.full(len(frequency), gamma)], axis=1)  # fmt: skip
        held = np.clip(asked, self.low, self.high)
        return groups(*held.T), float(held[0, 0] * onset(gamma, self.onset_g))

    def leave_one_out(self) -> pd.DataFrame:
        """Return the cases with the error of ln C_e predicted by the others, and its size."""
        error, expected = self.damping.leave_one_out()
        return self.cases.assign(log_error=error, log_standard_error=expected)

    # ------------------------------------------------------------------- files

    def to_dataset(self) -> xr.Dataset:
        """Return the surface on a grid to look at, with its cases and constants."""
        fills = np.unique(np.linspace(self.low[0], self.high[0], 17))
        frequency = np.exp(self._log_frequency[:: max(1, len(self._log_frequency) // 32)])
        gamma = np.exp(self._log_acceleration[:: max(1, len(self._log_acceleration) // 26)])
        grid = np.meshgrid(fills, frequency, gamma, indexing="ij")
        values = self.at(*(g.ravel() for g in grid))
        shape = grid[0].shape
        C_e, m_a = "equivalent viscous damping per area, C_e", "apparent mass per area, m_a"
        variables: list[tuple[str, Sequence[str], Array, str, str]] = [
            ("equivalent_damping", AXES, values.equivalent_damping.reshape(shape), "N s m-3", C_e),
            ("equivalent_damping_error", AXES, values.equivalent_damping_error.reshape(shape),
             "N s m-3", f"standard error of {C_e}"),
            ("apparent_mass", AXES, values.apparent_mass.reshape(shape), "kg m-2", m_a),
            ("inside", AXES, values.inside.reshape(shape).astype(np.int8), "1",
             "1 within the convex hull of the cases"),
        ]  # fmt: skip
        units = dict(zip((*AXES, VALUE, ERROR, MASS, MASS_ERROR),
                         ("1", "Hz", "g", "N s m-3", "N s m-3", "kg m-2", "kg m-2"),
                         strict=True))  # fmt: skip
        variables += [
            (f"case_{name}", ("case",), self.cases[name].to_numpy(float), unit, f"{name} of a case")
            for name, unit in units.items()
        ]
        for name, process in (("damping", self.damping), ("mass", self.mass)):
            if process is not None:
                constants = np.array([*process.lengths, process.size, process.scatter])
                variables.append(
                    (f"{name}_process", ("constant",), constants, "1",
                     "lengths of r, ln Γ and ln W/L, size and scatter of the process")
                )  # fmt: skip
        return xr.Dataset(
            {
                name: (list(dims), data, {"units": unit, "long_name": long_name})
                for name, dims, data, unit, long_name in variables
            },
            coords={
                axis: (axis, data, {"units": unit, "long_name": long_name})
                for axis, data, unit, long_name in zip(
                    AXES,
                    (fills, frequency, gamma),
                    ("1", "Hz", "g"),
                    ("fill fraction r", "frequency", "acceleration amplitude Γ"),
                    strict=True,
                )
            },
            attrs={"onset_g": self.onset_g, "mass_per_fill_kg_m2": self.mass_per_fill},
        )

    @staticmethod
    def from_dataset(dataset: xr.Dataset) -> DampingSurface:
        """Inverse of `to_dataset`."""
        names = (*AXES, VALUE, ERROR, MASS, MASS_ERROR)
        cases = pd.DataFrame({name: dataset[f"case_{name}"].to_numpy() for name in names})
        onset_g = float(dataset.attrs["onset_g"])
        mass_per_fill = float(dataset.attrs["mass_per_fill_kg_m2"])
        data = _training(cases, onset_g, mass_per_fill)

        def process(name: str) -> GaussianProcess | None:
            if f"{name}_process" not in dataset:
                return None
            *lengths, size, scatter = dataset[f"{name}_process"].to_numpy()
            return GaussianProcess(*data[name], np.array(lengths), float(size), float(scatter))

        damping = process("damping")
        if damping is None:
            raise DampingError("variable damping_process is missing: not a surface")
        return DampingSurface(cases, onset_g, mass_per_fill, damping, process("mass"))

    @staticmethod
    def from_frame(frame: pd.DataFrame, onset_g: float = 1.0) -> DampingSurface:
        """Make the surface of rows such as those of ``coupon/cases.csv``.

        Rows count whose status is "ok", whose C_e exceeds its own error (a value that does not
        has no logarithm to speak of) and whose Γ is above the onset.

        Parameters
        ----------
        frame
            Columns ``fill_fraction``, ``frequency_hz``, ``acceleration_g``,
            ``equivalent_damping_n_s_m3``; optional ``equivalent_damping_error_n_s_m3``,
            ``apparent_mass_kg_m2`` with ``apparent_mass_error_kg_m2`` (0 if left out),
            ``particle_mass_per_area_kg_m2`` (for the bound) and ``status``.
        onset_g
            Γ₀: gravity at the coupon over g; 0 for none.

        Raises
        ------
        DampingError
            If a column is missing, a point is duplicated, no row counts or too many do.
        """
        for column in (*AXES, VALUE):
            if column not in frame:
                raise DampingError(
                    f"column {column} is missing; there are {', '.join(frame.columns)}"
                )
        frame = frame.assign(**{c: 0.0 for c in (ERROR, MASS, MASS_ERROR) if c not in frame})
        if frame.duplicated(list(AXES)).any():
            twice = frame[frame.duplicated(list(AXES))].iloc[0]
            raise DampingError(
                "duplicate rows at " + ", ".join(f"{axis} = {twice[axis]:g}" for axis in AXES)
            )
        good = frame[frame["status"] == "ok"] if "status" in frame else frame
        good = good[(good[VALUE] > good[ERROR]) & (good["acceleration_g"] > onset_g)]
        if not 0 < len(good) <= MOST_CASES:
            raise DampingError(
                f"{len(good)} of {len(frame)} rows count (status ok, C_e above its error, "
                f"acceleration_g above {onset_g:g}): 1 to {MOST_CASES} are needed"
            )
        mass_per_fill = np.nan
        if PARTICLE_MASS in good:
            mass_per_fill = float((good[PARTICLE_MASS] / good["fill_fraction"]).median())
        cases = good[[*AXES, VALUE, ERROR, MASS, MASS_ERROR]].astype(float).reset_index(drop=True)
        data = _training(cases, onset_g, mass_per_fill)
        return DampingSurface(
            cases,
            onset_g,
            mass_per_fill,
            gaussian_process.fit(*data["damping"]),
            gaussian_process.fit(*data["mass"]) if (cases[MASS] != 0).any() else None,
        )


def _training(
    cases: pd.DataFrame, onset_g: float, mass_per_fill: float
) -> dict[str, tuple[Array, Array, Array]]:
    """Points, values and errors to which g_C and g_m are fitted."""
    fill, frequency, gamma = cases[list(AXES)].to_numpy(float).T
    point, h = groups(fill, frequency, gamma), onset(gamma, onset_g)
    value, error = cases[VALUE].to_numpy(float), cases[ERROR].to_numpy(float)
    rest = mass_per_fill if np.isfinite(mass_per_fill) else 0.0
    mass, mass_error = cases[MASS].to_numpy(float), cases[MASS_ERROR].to_numpy(float)
    return {
        "damping": (point, np.log(value / (h * fill * frequency)), error / value),
        "mass": (point, (mass / fill - (1 - h) * rest) / h, mass_error / (fill * h)),
    }


def _even(low: float, high: float, step: float) -> Array:
    """Even values from ``low`` to ``high``, at most ``step`` apart, at least two."""
    if high - low < 1e-9:
        return np.array([low, low + step])
    return np.linspace(low, high, max(2, int(np.ceil((high - low) / step)) + 1))


def _logarithmic(points: Array) -> Array:
    """(n, 3) r, f, Γ → r, ln f, ln Γ."""
    return np.stack([points[:, 0], np.log(points[:, 1]), np.log(points[:, 2])], axis=1)


def _facets(points: Array) -> tuple[Flags, Array, Array]:
    """Axes along which points (n, 3) spread, and normals and offsets of their convex hull."""
    spread = np.ptp(points, axis=0) > 1e-9
    of = points[:, spread]
    if of.shape[1] < 2:  # the lowest and highest value are all there is to a hull
        return spread, np.zeros((1, of.shape[1])), np.full(1, -1.0)
    # joggled, so that cases in one plane have a hull (of no volume) and no error
    flat = np.linalg.matrix_rank(of - of[0], tol=1e-6) < of.shape[1]
    hull = ConvexHull(of, qhull_options="QJ" if flat else "")
    return spread, hull.equations[:, :-1], hull.equations[:, -1]
