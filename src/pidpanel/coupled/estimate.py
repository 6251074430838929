"""From the records of a scenario to C_e, m_a and own force, with the errors of the response.

C_e, m_a and own force of whole patches follow from those of the simulated cells; the response is
then that of a linear panel in closed form, so that the chance of a short record of sound does not
enter. Errors are those of the jackknife (Efron and Stein 1981) over the segments of all records,
which scatter as the particles do, and over the cells, which scatter as packings do. Responses are
carried to first order in the changes of C_e, m_a and own force.

What the records show over what the linear panel with the own force of the simulated cells does
under the same sound is the residual. Beyond its own scatter it is an error of the split of the
walls' force into a linear and an own part.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Complexes
from pidpanel.coupled.coupled_panel import CoupledPanel, CoupledPatch, Impedance
from pidpanel.coupled.impedance import BandImpedance, ImpedanceSums
from pidpanel.coupled.own_force import OwnForce, fitted_own_force
from pidpanel.coupled.segments import RecordSegments, SettledRecord
from pidpanel.coupled.variants import EXPONENT, EXPONENT_ERROR, Variants, simulated_psd

PASSES = 3
"""Passes in which the instrument is the motion with the impedance of the pass before; C_e moves
by less than 1 % from the second to the third."""


class RecordTooShort(ValueError):
    """Records whose segments do not resolve the third octaves."""


@dataclass(frozen=True)
class PatchEstimate:
    """C_e, m_a and own force of a patch, by third octave.

    Attributes
    ----------
    impedance
        Z with its nodes.
    equivalent_damping_error, apparent_mass_error
        (bands,) standard errors [N s/m³], [kg/m²].
    own
        PSD and coherence of the own force.
    own_error
        (bands,) relative standard error of its PSD [1].
    common_error
        Relative standard error of all C_e together, from the motion of the records to that of the
        panel [1].
    """

    impedance: BandImpedance
    equivalent_damping_error: Array
    apparent_mass_error: Array
    own: OwnForce
    own_error: Array
    common_error: float


@dataclass(frozen=True)
class ScenarioEstimate:
    """What the records of a scenario tell.

    Attributes
    ----------
    centre
        (bands,) of the third octaves [Hz].
    patches
        Estimates in the order of the patches.
    frequency
        (nf,) [Hz] of the PSDs.
    psd, linear_psd
        (nf, p) PSD of the displacement at the points, and the same without own force [m²/Hz].
    log_psd_error
        (nf, p) standard error of ln of the PSD.
    log_band_error, band_residual
        (bands, p) standard error of ln of the mean square of the acceleration in each third
        octave, and ln of the recorded mean square over the predicted one.
    log_error, residual
        (p,) the same of the whole.
    recorded
        (p,) mean square of the acceleration of the records, with the own force of few cells
        [(m/s²)²].
    """

    centre: Array
    patches: Sequence[PatchEstimate]
    frequency: Array
    psd: Array
    linear_psd: Array
    log_psd_error: Array
    log_band_error: Array
    band_residual: Array
    log_error: Array
    residual: Array
    recorded: Array


def _zero(frequency: Array) -> Complexes:
    return np.zeros(frequency.shape, complex)


def estimate(
    panel: CoupledPanel,
    records: Sequence[SettledRecord],
    frequency: Array,
    centre: Array,
    edge: Array,
    bias: float = 0.0,
) -> ScenarioEstimate:
    """Return what the records of a scenario tell of the panel.

    Parameters
    ----------
    panel
        In its sound.
    records
        One or more.
    frequency
        (nf,) lines of the PSDs [Hz].
    centre, edge
        (bands,) and (bands, 2) third octaves that cover them [Hz].
    bias
        Of g rms by softened contacts [1], which is part of every error.

    Raises
    ------
    RecordTooShort
        If a third octave holds no line of the segments.
    """
    band = (float(edge[0, 0]), float(edge[-1, 1]))
    runs = [RecordSegments(panel, record, band) for record in records]
    patches = range(len(panel.patches))
    lines = np.array([run.lines(edge) for run in runs for _ in range(run.count)])
    if not lines.all():
        empty = centre[np.argmin(lines.min(axis=0))]
        raise RecordTooShort(f"the third octave of {empty:.4g} Hz contains no line of a segment")
    impedances: list[Impedance] = [_zero for _ in patches]
    for _ in range(PASSES):
        motions = [run.linear_motion(impedances) for run in runs]
        sums = [
            ImpedanceSums.joined(
                [
                    run.impedance_sums(motion, p, edge)
                    for run, motion in zip(runs, motions, strict=True)
                ]
            )
            for p in patches
        ]
        found = [of_patch.impedance() for of_patch in sums]
        impedances = list(found)
    own_sums = [
        np.concatenate([run.own_force(impedances[p], p, edge) for run in runs]) for p in patches
    ]
    own = [_own_force(own_sums[p], lines, centre, panel.patches[p]) for p in patches]
    squares = np.concatenate([run.velocity_squares() for run in runs])
    variants = Variants.of(panel, frequency, centre, impedances, own)
    whole = variants.at_motion(squares.mean(axis=0))
    found = [z.scaled(factor) for z, factor in zip(found, whole, strict=True)]
    variants = Variants.of(panel, frequency, centre, found, own)

    def scaled(kept: Array, cells: dict[int, Array]) -> list[Impedance]:
        factors = variants.at_motion(kept @ squares / kept.sum(), reference=whole)
        return [
            sums[p].impedance(segments=kept, cells=cells.get(p)).scaled(factors[p]) for p in patches
        ]

    every = np.ones(len(lines))
    segments = [
        variants.change(scaled(kept, {}), [_psd_ratio(own_sums[p], lines, kept) for p in patches])
        for kept in _leave_one_out(len(lines))
    ]
    cells = [
        [
            variants.change(scaled(every, {p: kept}), None)
            for kept in _leave_one_out(sums[p].force.shape[1])
        ]
        for p in patches
    ]
    motions = [run.linear_motion(impedances) for run in runs]
    recorded = np.concatenate([run.squares(run.recorded, edge) for run in runs])
    simulated = variants.band_squares(
        simulated_psd(panel, frequency, centre, impedances, own_sums, lines), edge
    )
    predicted = simulated + np.concatenate(
        [run.predicted_squares(motion, edge) for run, motion in zip(runs, motions, strict=True)]
    )
    band_residual, band_excess = _residual(recorded, predicted)
    residual, excess = _residual(recorded.sum(axis=1), predicted.sum(axis=1))
    of_motion = variants.change(
        [z.scaled(f ** (EXPONENT_ERROR / EXPONENT)) for z, f in zip(found, whole, strict=True)],
        None,
    )

    def error(of: Callable[[Array], Array]) -> Array:
        parts = [segments, *cells]
        variance = sum(_jackknife_variance([of(change) for change in part]) for part in parts)
        return np.sqrt(variance + of(of_motion) ** 2 + (2 * bias) ** 2)

    return ScenarioEstimate(
        centre=centre,
        patches=[
            _patch_estimate(sums[p], found[p], own[p], own_sums[p], lines, factor)
            for p, factor in zip(patches, whole.tolist(), strict=True)
        ],
        frequency=frequency,
        psd=variants.psd[:, variants.points],
        linear_psd=variants.linear_psd[:, variants.points],
        log_psd_error=error(lambda change: change[:, variants.points]),
        log_band_error=np.hypot(
            error(lambda change: variants.band_change(change, edge)), band_excess
        ),
        band_residual=band_residual,
        log_error=np.hypot(error(variants.total_change), excess),
        residual=residual,
        recorded=recorded.sum(axis=1).mean(axis=0),
    )


# ------------------------------------------------------------------------------- own force


def _own_force(sums: Array, lines: Array, centre: Array, patch: CoupledPatch) -> OwnForce:
    return fitted_own_force(sums.sum(axis=0), lines.sum(axis=0), centre, patch.distance)


def _psd_ratio(sums: Array, lines: Array, kept: Array) -> Array:
    """Return the PSD of the own force of the segments that are kept over that of all, (bands,)."""
    power = np.einsum("sbjj->sb", sums) / lines
    result: Array = (kept @ power) / kept.sum() / power.mean(axis=0)
    return result


# ------------------------------------------------------------------------------- errors


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
    result: Array = (n - 1) / n * ((values - values.mean(axis=0)) ** 2).sum(axis=0)
    return result


def _residual(recorded: Array, predicted: Array) -> tuple[Array, Array]:
    """Return ln of recorded over predicted mean squares, and what of it exceeds its scatter.

    Parameters
    ----------
    recorded, predicted
        (segments, …) mean squares.
    """
    kept = _leave_one_out(len(recorded))
    with np.errstate(divide="ignore", invalid="ignore"):  # of a point at rest
        value = np.log(recorded.sum(axis=0) / predicted.sum(axis=0))
        parts = [np.log(np.tensordot(w, recorded, 1) / np.tensordot(w, predicted, 1)) for w in kept]
    value, parts = np.nan_to_num(value), [np.nan_to_num(part) for part in parts]
    excess: Array = np.sqrt(np.maximum(value**2 - _jackknife_variance(parts), 0.0))
    return value, excess


def _patch_estimate(
    sums: ImpedanceSums,
    found: BandImpedance,
    own: OwnForce,
    own_sums: Array,
    lines: Array,
    factor: float,
) -> PatchEstimate:
    omega = 2 * np.pi * found.frequency

    def errors(of: Callable[[BandImpedance], Array]) -> Array:
        by_segment = [of(sums.impedance(segments=w)) for w in _leave_one_out(len(sums.force))]
        by_cell = [of(sums.impedance(cells=w)) for w in _leave_one_out(sums.force.shape[1])]
        variance = _jackknife_variance(by_segment) + _jackknife_variance(by_cell)
        found: Array = np.sqrt(variance)
        return found

    ratios = [_psd_ratio(own_sums, lines, w) for w in _leave_one_out(len(lines))]
    return PatchEstimate(
        impedance=found,
        equivalent_damping_error=errors(lambda z: np.asarray(z.value.real)),
        apparent_mass_error=errors(lambda z: np.asarray(z.value.imag / omega)),
        own=own,
        own_error=np.sqrt(_jackknife_variance(ratios)),
        common_error=abs(np.log(factor)) * EXPONENT_ERROR / EXPONENT,
    )
