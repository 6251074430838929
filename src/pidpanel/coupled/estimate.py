"""From the records of a scenario to C_e, m_a and own force, with the errors of the response.

C_e, m_a and own force of whole patches follow from those of the simulated cells; the response is
then that of a linear panel in closed form, so that the chance of a short record of sound does not
enter. What does:

- Z is known as well as the own force lets it be: its regression on a known motion has the variance
  Σ |Σ a n r*|² over the lines of a band (White 1980).
- Packings: the jackknife (Efron and Stein 1981) over the cells.
- PSD and coherence of the own force: the jackknife over segments and over cells.
- C_e is carried from the motion of the records to that of the panel with an exponent.
- Contacts are softer than those of the material; what that is known to change is taken out.

Responses are carried to first order in the changes of C_e, m_a and own force.

What the records show over what the linear panel with the own force of the simulated cells does
under the same sound is the residual. Beyond its own scatter it is an error of the split of the
walls' force into a linear and an own part.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.coupled.coupled_panel import CoupledPanel, CoupledPatch, Impedance
from pidpanel.coupled.impedance import BandImpedance, ImpedanceSums
from pidpanel.coupled.kurtosis import RecordedBursts, bursts_of
from pidpanel.coupled.own_force import OwnForce, fitted_own_force
from pidpanel.coupled.segments import RecordSegments, SettledRecord
from pidpanel.coupled.softening import Softened
from pidpanel.coupled.variants import EXPONENT, EXPONENT_ERROR, Variants, simulated_psd

# Passes in which the instrument is the motion with the impedance of the pass before; C_e moves
# by less than 1 % from the second to the third.
PASSES = 3


class RecordTooShort(ValueError):
    """Records whose segments do not resolve the third octaves."""


@dataclass(frozen=True)
class PatchEstimate:
    """C_e, m_a and own force of a patch, by third octave."""

    impedance: BandImpedance
    # (bands,) standard errors [N s/m³], [kg/m²]
    equivalent_damping_error: Array
    apparent_mass_error: Array
    own_force: OwnForce
    # (bands,) relative standard error of the PSD of the own force on the whole patch [1]
    own_force_error: Array
    # Relative standard error of all C_e together, from the motion of the records to that of the
    # panel and from soft contacts to those of the material [1]
    common_error: float


@dataclass(frozen=True)
class ScenarioEstimate:
    """Estimates from the records of a scenario."""

    centre: Array  # (bands,) of the third octaves [Hz]
    patches: Sequence[PatchEstimate]
    frequency: Array  # (nf,) [Hz] of the PSDs
    # (nf, p) PSD of the displacement at the points, and the same without own force [m²/Hz]
    psd: Array
    linear_psd: Array
    log_psd_error: Array  # (nf, p) standard error of ln of the PSD
    # (bands, p) standard error of ln of the mean square of the acceleration in each third octave,
    # and ln of the recorded mean square over the predicted one
    log_band_error: Array
    band_residual: Array
    # (p,) the same of the whole, and what of the residual exceeds its scatter (the split)
    log_error: Array
    residual: Array
    split_error: Array
    contact_error: Array  # (p,) part of `log_error` by softened contacts
    # (p,) mean square of the acceleration of the records, with the own force of few cells [(m/s²)²]
    recorded: Array
    bursts: RecordedBursts  # of the accelerations of the records

    @property
    def reducible_error(self) -> Array:
        """Relative error of g rms that further runs reduce, (p,) [1].

        That is neither the error of the contacts nor that of the split.
        """
        square = self.log_error**2 - self.split_error**2 - self.contact_error**2
        return np.sqrt(np.maximum(square, 0.0)) / 2


def estimate(
    panel: CoupledPanel,
    records: Sequence[SettledRecord],
    frequency: Array,
    centre: Array,
    edge: Array,
    softened: Sequence[Softened] = (),
    whole: CoupledPanel | None = None,
) -> ScenarioEstimate:
    """Return the estimates of the panel's response from the records of a scenario.

    Parameters
    ----------
    frequency
        (nf,) lines of the PSDs [Hz].
    centre, edge
        (bands,) and (bands, 2) third octaves that cover them [Hz].
    softened
        Contacts of each patch; none for those of the material. What they change in C_e is
        taken out; the errors are those of what is left.
    whole
        The panel of which the response is returned; None for that of the records.

    Raises
    ------
    RecordTooShort
        If a third octave holds no line of the segments.
    """
    band = (float(edge[0, 0]), float(edge[-1, 1]))
    runs = [RecordSegments(panel, record, band) for record in records]
    lines = np.array([run.lines(edge) for run in runs for _ in range(run.count)])
    if not lines.all():
        empty = centre[np.argmin(lines.min(axis=0))]
        raise RecordTooShort(f"the third octave of {empty:.4g} Hz contains no line of a segment")
    fits, impedances = _fits(panel, runs, centre, edge, lines)
    forces = [fit.own_force() for fit in fits]
    squares = np.concatenate([run.velocity_squares() for run in runs]).mean(axis=0)
    whole = whole or panel
    softened = softened or [Softened(np.inf)] * len(fits)
    gain, gain_error = np.array([(soft.gain, soft.gain_error) for soft in softened]).T
    stiff = [z.scaled(factor) for z, factor in zip(impedances, np.exp(-gain), strict=True)]
    moved = np.log(Variants(whole, frequency, centre, stiff, forces).at_motion(squares))
    factors = np.exp(moved - gain)
    carried = [z.scaled(factor) for z, factor in zip(impedances, factors, strict=True)]
    variants = Variants(whole, frequency, centre, carried, forces)
    # ln C_e of each patch that another exponent and other contacts would change, (2, patches)
    unsure = np.array([EXPONENT_ERROR / EXPONENT * moved, gain_error])
    changes = [_scaled(variants, carried, change) for change in unsure]
    bias = max(soft.bias for soft in softened)
    variance = _variance(variants, fits, carried, factors, changes, bias)
    own_force = simulated_psd(
        panel, frequency, centre, impedances, [fit.force_sums for fit in fits], lines
    )
    recorded = np.concatenate([run.squares(run.recorded, edge) for run in runs])
    linear = [run.squares(run.linear_motion(impedances), edge) for run in runs]
    by_band, total = _residuals(recorded, variants.band_squares(own_force, edge), linear)
    band_variance = variance(lambda change: variants.band_change(change, edge))
    return ScenarioEstimate(
        centre=centre,
        patches=[
            _patch_estimate(*parts)
            for parts in zip(fits, carried, forces, np.hypot(*unsure).tolist(), strict=True)
        ],
        frequency=frequency,
        psd=variants.psd[:, variants.points],
        linear_psd=variants.linear_psd[:, variants.points],
        log_psd_error=np.sqrt(variance(lambda change: change[:, variants.points])),
        log_band_error=np.hypot(np.sqrt(band_variance), by_band[1]),
        band_residual=by_band[0],
        log_error=np.hypot(np.sqrt(variance(variants.total_change)), total[1]),
        residual=total[0],
        split_error=total[1],
        contact_error=np.hypot(2 * bias, variants.total_change(changes[1])),
        recorded=recorded.sum(axis=1).mean(axis=0),
        bursts=bursts_of(records),
    )


def _residuals(
    recorded: Array, own_force: Array, linear: Sequence[Array]
) -> tuple[tuple[Array, Array], tuple[Array, Array]]:
    """Return `_residual` by band, and that of all bands together.

    ``recorded`` and each of ``linear`` are mean squares (segments, bands, p); ``own_force`` is that
    of the simulated cells.
    """
    predicted = own_force + np.concatenate(linear)
    return _residual(recorded, predicted), _residual(recorded.sum(axis=1), predicted.sum(axis=1))


# --------------------------------------------------------------------- Z and own force


@dataclass(frozen=True)
class _PatchFit:
    """Sums over the records from which Z and own force of a patch follow."""

    # The patch, its sums with the instrument, and (bands,) [Hz]
    patch: CoupledPatch
    sums: ImpedanceSums
    centre: Array
    # (segments, bands, cells, cells) Re Σ n_j n_k* and (segments, bands) lines in them
    force_sums: Array
    lines: Array

    @property
    def cells(self) -> int:
        return self.force_sums.shape[2]

    def impedances_of_fewer_cells(self) -> list[BandImpedance]:
        """Return Z with each cell of each run left out in turn."""
        count = self.sums.force.shape[1]
        return [self.sums.impedance(cells=weights) for weights in _leave_one_out(count)]

    def own_force(self, segments: Array | None = None, cells: Array | None = None) -> OwnForce:
        """Fit the own force, without the segments or the cells whose weight is 0."""
        used_segments = slice(None) if segments is None else segments > 0
        used_cells = np.ones(self.cells, bool) if cells is None else cells > 0
        sums = self.force_sums[used_segments].sum(axis=0)[:, used_cells][:, :, used_cells]
        distance = self.patch.distance[used_cells][:, used_cells]
        return fitted_own_force(sums, self.lines[used_segments].sum(axis=0), self.centre, distance)

    @cached_property
    def _shared_areas(self) -> dict[float, Array]:
        return {}

    def resultant(self, force: OwnForce) -> Array:
        """Return the PSD of the own force on the whole patch, (bands,) [N²/Hz]."""
        if force.length not in self._shared_areas:
            area = self.patch.shared_area(force.length, self.centre)
            self._shared_areas[force.length] = area
        independent = self.patch.cell_area * self.patch.area.sum()
        shared = force.coherence * self._shared_areas[force.length]
        return force.psd * (shared + (1 - force.coherence) * independent)

    def ratios(self, *, unit: str) -> list[Array]:
        """Return the resultants with one segment or cell left out over that of all, (bands,)."""
        count = self.cells if unit == "cells" else len(self.lines)
        whole = self.resultant(self.own_force())
        fitted = [self.own_force(**{unit: weights}) for weights in _leave_one_out(count)]
        return [
            np.divide(self.resultant(force), whole, out=np.ones_like(whole), where=whole > 0)
            for force in fitted
        ]


def _fits(
    panel: CoupledPanel, runs: Sequence[RecordSegments], centre: Array, edge: Array, lines: Array
) -> tuple[list[_PatchFit], list[BandImpedance]]:
    """Return the sums over all records, with the Z from which the own force follows."""
    patches = range(len(panel.patches))
    impedances: Sequence[Impedance] = [lambda f: np.zeros(f.shape, complex)] * len(patches)
    for _ in range(PASSES):
        moved = [(run, run.linear_motion(impedances)) for run in runs]
        sums = [
            ImpedanceSums.joined([run.impedance_sums(motion, p, edge) for run, motion in moved])
            for p in patches
        ]
        fitted = [of_patch.impedance() for of_patch in sums]
        impedances = fitted
    force_sums = [
        np.concatenate([run.own_force(fitted[p], p, edge) for run in runs]) for p in patches
    ]
    fits = [_PatchFit(panel.patches[p], sums[p], centre, force_sums[p], lines) for p in patches]
    return fits, fitted


# ------------------------------------------------------------------------------- errors


def _variance(
    variants: Variants,
    fits: Sequence[_PatchFit],
    carried: Sequence[BandImpedance],
    factors: Array,
    changes: Sequence[Array],
    bias: float,
) -> Callable[[Callable[[Array], Array]], Array]:
    """Return the variance of what follows from the change of ln of the PSD, as a function of it."""
    same = np.ones(len(variants.centre))

    def changed(p: int, impedance: Impedance, ratio: Array = same) -> Array:
        impedances: list[Impedance] = [*carried]
        ratios = [same] * len(fits)
        impedances[p], ratios[p] = impedance, ratio
        return variants.change(impedances, ratios)

    independent, jackknifed = [*changes], []
    for p, (fit, z, factor) in enumerate(zip(fits, carried, factors.tolist(), strict=True)):
        independent += [changed(p, deviated) for deviated in z.deviated()]
        jackknifed += [
            [changed(p, fewer.scaled(factor)) for fewer in fit.impedances_of_fewer_cells()],
            [changed(p, z, ratio) for ratio in fit.ratios(unit="cells")],
            [changed(p, z, ratio) for ratio in fit.ratios(unit="segments")],
        ]

    def variance(quantity: Callable[[Array], Array]) -> Array:
        parts = [quantity(change) ** 2 for change in independent]
        parts += [
            _jackknife_variance([quantity(change) for change in part])
            for part in jackknifed
            if part
        ]
        return np.sum(parts, axis=0) + (2 * bias) ** 2

    return variance


def _scaled(variants: Variants, carried: Sequence[BandImpedance], log_factor: Array) -> Array:
    """Return the change of ln of the PSD with other C_e of all patches."""
    scaled = [z.scaled(factor) for z, factor in zip(carried, np.exp(log_factor), strict=True)]
    return variants.change(scaled, [np.ones(len(variants.centre))] * len(carried))


def _leave_one_out(count: int) -> Array:
    """Return weights (count, count) with each one left out in turn; none for a single one."""
    return 1 - np.eye(count) if count > 1 else np.zeros((0, 1))


def _jackknife_variance(changes: Sequence[Array]) -> Array:
    """Return (n − 1)/n Σ (x − mean)² of estimates with one unit left out.

    Examples
    --------
    The mean of 1, 2, 6: the variance over 3.

    >>> leave_out = [np.array(4.0), np.array(3.5), np.array(1.5)]
    >>> round(float(_jackknife_variance(leave_out)), 6)
    2.333333
    """
    values = np.array(changes)
    n = len(values)
    return (n - 1) / n * ((values - values.mean(axis=0)) ** 2).sum(axis=0)


def _residual(recorded: Array, predicted: Array) -> tuple[Array, Array]:
    """Return ln of recorded over predicted mean squares, and what of it exceeds its scatter."""
    weights = _leave_one_out(len(recorded))
    with np.errstate(divide="ignore", invalid="ignore"):  # of a point at rest
        value = np.log(recorded.sum(axis=0) / predicted.sum(axis=0))
        parts = [
            np.log(np.tensordot(w, recorded, 1) / np.tensordot(w, predicted, 1)) for w in weights
        ]
    value, parts = np.nan_to_num(value), [np.nan_to_num(part) for part in parts]
    excess: Array = np.sqrt(np.maximum(value**2 - _jackknife_variance(parts), 0.0))
    return value, excess


def _patch_estimate(
    fit: _PatchFit, carried: BandImpedance, force: OwnForce, common_error: float
) -> PatchEstimate:
    by_cell = [fewer.value for fewer in fit.impedances_of_fewer_cells()]
    ratios = fit.ratios(unit="segments")
    no_error = np.zeros(len(fit.centre))

    def error(part: Callable[[Complexes], Array]) -> Array:
        variance = (part(carried.deviation) ** 2).sum(axis=1)
        if by_cell:
            variance = variance + _jackknife_variance([part(value) for value in by_cell])
        return np.sqrt(variance)

    return PatchEstimate(
        impedance=carried,
        equivalent_damping_error=error(np.real),
        apparent_mass_error=error(np.imag) / (2 * np.pi * carried.frequency),
        own_force=force,
        own_force_error=np.sqrt(_jackknife_variance(ratios)) if ratios else no_error,
        common_error=common_error,
    )
