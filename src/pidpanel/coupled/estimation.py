"""Several records of one panel become one answer with its error.

The mean over records is that of the cross-spectra behind Z and of the PSDs of the beds' own force.
Errors are those of the records left out one by one (jackknife): with them go the packings, the
sounds and the lengths of the records, whatever their distribution. What the linear panel with the
own force of the cells that were simulated does under the very sound of a record is compared with
what was recorded: a residual beyond its own scatter belongs to the error.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, fields

import numpy as np

from pidpanel.arrays import Array
from pidpanel.coupled.identification import BandImpedance, OwnForce


def leave_one_out(parts: Sequence[Array]) -> list[Array]:
    """Return the sum of all parts, then of all but each.

    Examples
    --------
    >>> [one.tolist() for one in leave_one_out([np.array([1.0]), np.array([4.0])])]
    [[5.0], [4.0], [1.0]]
    """
    total = np.sum(parts, axis=0)
    return [total, *(total - part for part in parts)] if len(parts) > 1 else [total]


def jackknife_error(left_out: Array) -> Array:
    """Return the standard error of an estimate from those with one record left out.

    √((n − 1)/n Σ (x₋ᵢ − mean)²) (Efron and Stein 1981); NaN of a single record.

    Parameters
    ----------
    left_out
        (n, …).

    Examples
    --------
    The mean of 1, 2, 6: the scatter over √3.

    >>> round(float(jackknife_error(np.array([4.0, 3.5, 1.5]))), 6)
    1.527525
    """
    n = len(left_out)
    if n < 2:
        return np.full(left_out.shape[1:], np.nan)
    apart = left_out - left_out.mean(axis=0)
    error: Array = np.sqrt((n - 1) / n * (apart**2).sum(axis=0))
    return error


def mean_impedances(parts: Sequence[BandImpedance]) -> list[BandImpedance]:
    """Return the sum of the cross-spectra of all records, then of all but each."""
    sums = [leave_one_out([getattr(part, f.name) for part in parts]) for f in fields(BandImpedance)]
    return [BandImpedance(*one) for one in zip(*sums, strict=True)]


def mean_own_forces(parts: Sequence[OwnForce]) -> list[OwnForce]:
    """Return the mean of the PSDs of all records, then of all but each."""
    counts = [len(parts), *(len(parts) - 1 for _ in parts)]
    independent, common, variance = (
        leave_one_out([getattr(part, f.name) for part in parts]) for f in fields(OwnForce)
    )
    return [
        OwnForce(independent[k] / n, common[k] / n, variance[k] / n**2)
        for k, n in enumerate(counts[: len(independent)])
    ]


@dataclass(frozen=True)
class Residual:
    """What was recorded over what the linear panel with its own force does, in ln of a PSD.

    Attributes
    ----------
    value, error
        (…) ln ratio and its standard error.
    """

    value: Array
    error: Array

    @property
    def excess(self) -> Array:
        """(…) what of the ratio is not its own scatter."""
        square = self.value**2 - np.nan_to_num(self.error) ** 2
        found: Array = np.sqrt(np.maximum(square, 0.0))
        return found


def residual(recorded: Sequence[Array], predicted: Sequence[Array]) -> Residual:
    """Return the residual of mean squares over records.

    Parameters
    ----------
    recorded, predicted
        Of each record, (…).
    """
    ratios = [
        np.log(one / other)
        for one, other in zip(leave_one_out(recorded), leave_one_out(predicted), strict=True)
    ]
    return Residual(ratios[0], jackknife_error(np.array(ratios[1:]).reshape(-1, *ratios[0].shape)))
