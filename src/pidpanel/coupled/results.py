"""From the records of one scenario to C_e, m_a, own force and the PSDs of the whole patches."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.coupled import estimation, identification, linear
from pidpanel.coupled.identification import BandImpedance, OwnForce
from pidpanel.coupled.sound_record import samples
from pidpanel.response.bands import band_rms
from pidpanel.response.lines import root_mean_square

PASSES = 3
"""Passes in which the instrument is the motion with the impedance of the pass before; C_e moves
by less than 1 % from the second to the third."""


@dataclass(frozen=True)
class CoupledPatch:
    """A filled patch, as its stations and as a whole.

    Attributes
    ----------
    shape
        (k, n) the shapes at its stations [1].
    area
        (k,) for which they stand [m²].
    cell_area
        Of the cells that were simulated at one station [m²].
    overlap
        (n, n) D [m²].
    """

    shape: Array
    area: Array
    cell_area: float
    overlap: Array

    @property
    def factor(self) -> Array:
        """(n, r) E with D = E Eᵀ, parts below 1e-8 of the largest left out [m]."""
        value, vector = np.linalg.eigh((self.overlap + self.overlap.T) / 2)
        kept = value > 1e-8 * value[-1]
        found: Array = vector[:, kept] * np.sqrt(value[kept])
        return found


@dataclass(frozen=True)
class CoupledPanel:
    """The panel in its sound with the patches of a scenario.

    Attributes
    ----------
    stiffness
        Z₀ over frequency: (nf,) [Hz] to (nf, n) [N/m].
    points
        (p, n) the shapes at the points [1].
    patches
        Filled ones, in the order of the stations of a record.
    pressure_psd
        S_p over frequency [Pa²/Hz].
    modal_force
        G over frequency [m⁴].
    """

    stiffness: Callable[[Array], Complexes]
    points: Array
    patches: Sequence[CoupledPatch]
    pressure_psd: Callable[[Array], Array]
    modal_force: Callable[[Array], Array | Complexes]

    @property
    def bounds(self) -> list[slice]:
        """Stations of each patch."""
        ends = np.cumsum([0] + [len(patch.area) for patch in self.patches]).tolist()
        return [slice(first, last) for first, last in pairwise(ends)]

    @property
    def at_stations(self) -> Array:
        """(k, n) the shapes at all stations."""
        return np.concatenate([patch.shape for patch in self.patches])

    @property
    def area(self) -> Array:
        """(k,) for which all stations stand [m²]."""
        return np.concatenate([patch.area for patch in self.patches])


@dataclass(frozen=True)
class SettledRecord:
    """A record from where it has settled, with its sound.

    Attributes
    ----------
    frequency, amplitude
        (nf,) of the tones of its sound [Hz] and (nf, n) their modal forces [N].
    first, rows, settled
        Number of the first tone in periods of the record, rows of the record, and the first row
        that counts.
    interval
        Between the rows [s].
    at_stations, at_points, impulse
        As of `integration.Record`.
    """

    frequency: Array
    amplitude: Complexes
    first: int
    rows: int
    settled: int
    interval: float
    at_stations: Array
    at_points: Array
    impulse: Array


@dataclass(frozen=True)
class CoupledResult:
    """What the records of a scenario tell.

    Attributes
    ----------
    centre
        (bands,) of the third octaves [Hz].
    equivalent_damping, apparent_mass
        (patches, bands) C_e [N s/m³] and m_a [kg/m²].
    equivalent_damping_error, apparent_mass_error
        Their standard errors.
    independent, common
        (patches, bands) PSDs of the own force of the mean of the cells of one station, of the part
        that differs from station to station and of that which all share [Pa²/Hz].
    displacement_psd, ln_error
        (nf, p) PSD of the whole panel at its points [m²/Hz], and the standard error of its ln.
    linear_psd
        (nf, p) the same without the beds' own force.
    band_squares
        (bands, p) mean square of the acceleration in each third octave [(m/s²)²].
    band_error
        (bands, p) standard error of ln of the mean square of the acceleration.
    band_residual
        (bands, p) ln of what was recorded over what is expected of the cells that were simulated.
    mean_square, mean_square_error
        (p,) of the acceleration [(m/s²)²] and the standard error of its ln.
    mean_square_residual
        (p,) as of the bands.
    linear_mean_square
        (p,) of the acceleration without the beds' own force [(m/s²)²].
    simulated_own
        (p,) mean square that the own force of the cells that were simulated adds, over that of
        the whole patches [1].
    """

    centre: Array
    equivalent_damping: Array
    apparent_mass: Array
    equivalent_damping_error: Array
    apparent_mass_error: Array
    independent: Array
    common: Array
    displacement_psd: Array
    ln_error: Array
    linear_psd: Array
    band_squares: Array
    band_error: Array
    band_residual: Array
    mean_square: Array
    mean_square_error: Array
    mean_square_residual: Array
    linear_mean_square: Array
    simulated_own: Array


Impedance = Callable[[Array], Complexes]
"""Z over frequency of a patch."""


def coupled_result(
    panel: CoupledPanel,
    records: Sequence[SettledRecord],
    frequency: Array,
    centre: Array,
    edge: Array,
) -> CoupledResult:
    """Return what the records of a scenario tell of the panel.

    Parameters
    ----------
    panel
        In its sound.
    records
        One or more; errors are NaN of one.
    frequency
        (nf,) lines of the PSDs [Hz].
    centre, edge
        (bands,) and (bands, 2) third octaves that cover them [Hz].
    """
    seen = [_Seen(panel, record) for record in records]
    impedances: list[Impedance] = [_none for _ in panel.patches]
    for _ in range(PASSES):
        motions = [one.motion(impedances) for one in seen]
        sums = [
            estimation.mean_impedances(
                [
                    one.band_impedance(motion, p, edge)
                    for one, motion in zip(seen, motions, strict=True)
                ]
            )
            for p in range(len(panel.patches))
        ]
        impedances = [_over(edge, of_patch[0]) for of_patch in sums]
    own = [
        estimation.mean_own_forces([one.own_force(impedances[p], p, edge) for one in seen])
        for p in range(len(panel.patches))
    ]
    variants = [
        _Beds([_over(edge, z[i]) for z in sums], [n[i] for n in own], centre)
        for i in range(len(sums[0]))
    ]
    nothing = np.zeros(len(centre))
    none = [OwnForce(nothing, nothing, nothing) for _ in own]
    linear_psd, *psds = _of_patches(
        panel, frequency, [_Beds(variants[0].impedances, none, centre), *variants]
    )
    acceleration = [(2 * np.pi * frequency[:, None]) ** 4 * psd for psd in psds]
    bands = np.array([band_rms(frequency, psd, edge) ** 2 for psd in acceleration])
    squares = np.array([root_mean_square(frequency, psd) ** 2 for psd in acceleration])
    # of the cells that were simulated, under the sound of the record
    noise = _of_stations(panel, frequency, variants[0])
    noise_bands = band_rms(frequency, (2 * np.pi * frequency[:, None]) ** 4 * noise, edge) ** 2
    recorded = [one.band_squares(one.spectra.values[:, one.points], edge) for one in seen]
    expected = [
        one.band_squares(one.motion(impedances)[:, one.points], edge) + noise_bands for one in seen
    ]
    of_bands = estimation.residual(recorded, expected)
    of_all = estimation.residual(
        [one.sum(axis=0) for one in recorded], [one.sum(axis=0) for one in expected]
    )
    # few records may agree by chance where the lines of each scatter
    known = np.array([z[0].error for z in sums])
    values = np.array([[z(centre) for z in one.impedances] for one in variants])
    mass = values.imag / (2 * np.pi * centre)
    linear_square = (
        root_mean_square(frequency, (2 * np.pi * frequency[:, None]) ** 4 * linear_psd) ** 2
    )
    return CoupledResult(
        centre=centre,
        equivalent_damping=values[0].real,
        apparent_mass=mass[0],
        equivalent_damping_error=np.fmax(estimation.jackknife_error(values[1:].real), known),
        apparent_mass_error=np.fmax(
            estimation.jackknife_error(mass[1:]), known / (2 * np.pi * centre)
        ),
        independent=np.array([of[0].independent for of in own]),
        common=np.array([of[0].likely_common for of in own]),
        displacement_psd=psds[0],
        ln_error=_ln_error(np.array(psds)),
        linear_psd=linear_psd,
        band_squares=bands[0],
        band_error=np.hypot(_ln_error(bands), of_bands.excess),
        band_residual=of_bands.value,
        mean_square=squares[0],
        mean_square_error=np.hypot(_ln_error(squares), of_all.excess),
        mean_square_residual=of_all.value,
        linear_mean_square=linear_square,
        simulated_own=noise_bands.sum(axis=0) / squares[0],
    )


def _none(frequency: Array) -> Complexes:
    return np.zeros(frequency.shape, complex)


def _over(edge: Array, found: BandImpedance) -> Impedance:
    value, at = found.value, np.clip(found.frequency, *edge.T)
    return lambda frequency: identification.over_frequency(frequency, at, value)


def _ln_error(values: Array) -> Array:
    """Return the error of ln of the first from those with one record left out, the others."""
    with np.errstate(divide="ignore", invalid="ignore"):  # of a point that is held
        return estimation.jackknife_error(np.log(values[1:]))


@dataclass(frozen=True)
class _Beds:
    """Impedance and own force of the bed of each patch."""

    impedances: Sequence[Impedance]
    own: Sequence[OwnForce]
    centre: Array

    def psd_of(self, patch: int, frequency: Array) -> tuple[Array, Array]:
        """Return the PSDs of the own force, independent and common, at (nf,) [Hz]."""
        found = self.own[patch]
        place, at = np.log(frequency), np.log(self.centre)
        independent, common = (
            np.interp(place, at, one) for one in (found.independent, found.likely_common)
        )
        # stations that push against each other are no part in common; a PSD is not negative
        return independent, np.maximum(common, 0.0)


class _Seen:
    """A record beside the panel that made it."""

    def __init__(self, panel: CoupledPanel, record: SettledRecord) -> None:
        self._panel, self._record = panel, record
        self._stiffness = panel.stiffness(record.frequency)
        self._shapes = np.concatenate([panel.at_stations, panel.points])
        self.points = slice(len(panel.at_stations), None)
        rows = np.concatenate([record.at_stations, record.at_points], axis=1)
        self.spectra = identification.spectra_of(rows[record.settled : -1], record.interval)
        self._pressure = identification.pressure_spectra(
            record.impulse[record.settled :], record.interval
        ).values
        self._omega = 2j * np.pi * self.spectra.frequency[:, None]

    def motion(self, impedances: Sequence[Impedance]) -> Complexes:
        """Return the spectra of the motion with linear dampers under the sound of the record."""
        record, panel = self._record, self._panel
        amplitude = linear.motion(
            record.frequency,
            self._stiffness,
            panel.at_stations.T,
            _station_load(panel, record.frequency, impedances),
            self._shapes,
            record.amplitude,
        )
        rows = samples(amplitude, record.first, record.rows)
        return identification.spectra_of(rows[record.settled : -1], record.interval).values

    def band_impedance(self, motion: Complexes, patch: int, edge: Array) -> BandImpedance:
        """Return the cross-spectra of a patch with a motion as instrument."""
        part = self._panel.bounds[patch]
        return identification.band_impedance(
            self.spectra.frequency,
            self._pressure[:, part],
            self._omega * self.spectra.values[:, part],
            self._omega * motion[:, part],
            self._panel.area[part],
            edge,
        )

    def own_force(self, impedance: Impedance, patch: int, edge: Array) -> OwnForce:
        """Return the PSDs of the own force of a patch."""
        part, frequency = self._panel.bounds[patch], self.spectra.frequency
        inside = (frequency >= edge[0, 0]) & (frequency <= edge[-1, 1])
        speed = (self._omega * self.spectra.values[:, part])[inside]
        own = self._pressure[inside][:, part] - impedance(frequency[inside])[:, None] * speed
        return identification.own_force(frequency[inside], own, edge)

    def band_squares(self, values: Complexes, edge: Array) -> Array:
        """Return the mean squares (bands, s) of the accelerations of displacements."""
        frequency = self.spectra.frequency
        psd = np.abs(self._omega**2 * values) ** 2
        step = frequency[1] - frequency[0]
        return np.asarray(identification.band_sums(frequency, psd, edge)) * step


def _station_load(
    panel: CoupledPanel, frequency: Array, impedances: Sequence[Impedance]
) -> Complexes:
    """Return diag(a_k Z_k), (nf, k, k)."""
    diagonal = np.concatenate(
        [
            impedance(frequency)[:, None] * patch.area
            for impedance, patch in zip(impedances, panel.patches, strict=True)
        ],
        axis=1,
    )
    load: Complexes = diagonal[:, :, None] * np.eye(diagonal.shape[1], dtype=np.complex128)
    return load


def _of_stations(panel: CoupledPanel, frequency: Array, beds: _Beds) -> Array:
    """Return the PSDs at the points of the own force of the cells that were simulated alone."""
    single = [(patch.area**2 * patch.shape.T) @ patch.shape for patch in panel.patches]
    none = np.zeros((1, panel.points.shape[1], panel.points.shape[1]))
    (found,) = linear.point_psds(
        frequency,
        panel.stiffness(frequency),
        panel.at_stations.T,
        [_station_load(panel, frequency, beds.impedances)],
        panel.points,
        np.zeros(frequency.shape),
        lambda _: none,
        [_own_psd(panel, frequency, beds, single)],
    )
    return found


def _of_patches(panel: CoupledPanel, frequency: Array, variants: Sequence[_Beds]) -> list[Array]:
    """Return the PSDs at the points of the whole patches, of each variant of the beds."""
    factors = [patch.factor for patch in panel.patches]
    felt = np.concatenate(factors, axis=1)
    owner = np.repeat(np.arange(len(factors)), [factor.shape[1] for factor in factors])

    def load(beds: _Beds) -> Complexes:
        of_patches = np.array([z(frequency) for z in beds.impedances])
        found: Complexes = of_patches[owner].T[:, :, None] * np.eye(len(owner), dtype=np.complex128)
        return found

    every = [patch.cell_area * patch.overlap for patch in panel.patches]
    return list(
        linear.point_psds(
            frequency,
            panel.stiffness(frequency),
            felt,
            [load(beds) for beds in variants],
            panel.points,
            panel.pressure_psd(frequency),
            panel.modal_force,
            [_own_psd(panel, frequency, beds, every) for beds in variants],
        )
    )


def _own_psd(
    panel: CoupledPanel, frequency: Array, beds: _Beds, independent: Sequence[Array]
) -> Callable[[slice], Array]:
    """Return the PSDs of the modal forces of the beds' own, of some lines of the frequencies.

    Parameters
    ----------
    panel, frequency, beds
        As elsewhere.
    independent
        (n, n) of each patch, what cells that know nothing of each other push [m⁴].
    """
    means = [patch.area @ patch.shape for patch in panel.patches]

    def psd(lines: slice) -> Array:
        total = np.zeros((len(frequency[lines]), *independent[0].shape))
        for p, (alone, mean) in enumerate(zip(independent, means, strict=True)):
            single, common = beds.psd_of(p, frequency[lines])
            total += single[:, None, None] * alone
            total += common[:, None, None] * np.outer(mean, mean)
        return total

    return psd
