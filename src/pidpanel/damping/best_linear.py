"""The best linear approximation of the force of a coupon on its velocity, in bands of frequency.

On each line of a random motion F = Z V + E with Z = C_e + iω m_a, and E the force that is not
linear in the motion. In a band, where C_e and m_a are taken as constant, least squares give

    C_e = Σ Re(F V*)/Σ |V|²,      m_a = Σ ω Im(F V*)/Σ ω² |V|²,

the cross-spectrum over the spectrum of the motion. E is uncorrelated with V and, over lines and
phases, random (Pintelon and Schoukens, *System Identification*, 2nd ed., section 4.3), so that the
scatter of the lines about the fit is the error. Packings that feel the same motion have a part of E
in common, whose cross-spectrum it is; the rest falls with the number of cells.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from pidpanel.arrays import Array, Complexes, Flags, Index

RESOLVED = 0.25
"""Relative standard error of C_e above which a band is joined with the next."""

WIDEST = 4.0
"""Highest over lowest frequency of a band that is joined."""

PACKING = 0.05
"""Relative standard deviation of C_e between packings, before it is seen: 3 to 7 % where long runs
of single tones state 0.5 %."""

PACKING_WEIGHT = 4.0
"""Degrees of freedom with which `PACKING` counts beside what the bands say."""


@dataclass(frozen=True)
class Leg:
    """What several packings made of one motion; spectra whose mean square is a PSD.

    Attributes
    ----------
    frequency
        (n,) [Hz].
    velocity
        (n,) [m/s/√Hz].
    force
        (n_packings, n) over the area [Pa/√Hz].
    """

    frequency: Array
    velocity: Complexes
    force: Complexes


@dataclass(frozen=True)
class LinearApproximation:
    """Z in bands, with its errors and the PSD of the force that is not linear in the motion.

    Attributes
    ----------
    low, high
        (n,) edges of the bands [Hz].
    frequency
        (n,) at which C_e and m_a hold: the mean of ln f over the power of the motion [Hz].
    equivalent_damping, equivalent_damping_error
        (n,) C_e and its standard error, as the lines scatter [N s/m³].
    apparent_mass, apparent_mass_error
        (n,) m_a and that of it [kg/m²].
    coherence
        (n,) share of Z V in the mean square of the force of one packing [1].
    common_psd, own_psd
        (n,) one-sided PSD of E over the area: what packings have in common, and what is one
        packing's own [Pa²/Hz].
    packing_error
        Relative standard error of all C_e and m_a together, since few packings were run [1].
    """

    low: Array
    high: Array
    frequency: Array
    equivalent_damping: Array
    equivalent_damping_error: Array
    apparent_mass: Array
    apparent_mass_error: Array
    coherence: Array
    common_psd: Array
    own_psd: Array
    packing_error: float


@dataclass(frozen=True)
class _Lines:
    """Lines of all legs."""

    frequency: Array
    velocity: Complexes
    force: Complexes
    """(n_packings, n)"""

    def only(self, some: Flags | Index) -> _Lines:
        return _Lines(self.frequency[some], self.velocity[some], self.force[:, some])


@dataclass(frozen=True)
class _Fit:
    """C_e and m_a of a band, or of each packing in it, with their variances."""

    damping: float
    mass: float
    damping_variance: float
    mass_variance: float


def approximate(legs: Sequence[Leg], edges: Array) -> LinearApproximation:
    """Return the best linear approximation.

    Parameters
    ----------
    legs
        Of the same packings.
    edges
        (m,) rising edges of bands [Hz]. Bands are joined until C_e is known to `RESOLVED`, but
        not beyond `WIDEST`.

    Raises
    ------
    ValueError
        Where legs have different packings, or no band has two lines.
    """
    if len({len(leg.force) for leg in legs}) != 1:
        raise ValueError("legs of different numbers of packings")
    lines = _Lines(
        np.concatenate([leg.frequency for leg in legs]),
        np.concatenate([leg.velocity for leg in legs]),
        np.concatenate([leg.force for leg in legs], axis=1),
    )
    bands = _bands(lines, edges)
    if not bands:
        raise ValueError(f"no band with two lines between {edges[0]:g} and {edges[-1]:g} Hz")
    parts = [lines.only(_within(lines, low, high)) for low, high in bands]
    fits = [_fit(part, part.force.mean(axis=0)) for part in parts]
    linear = [_linear(part, fit) for part, fit in zip(parts, fits, strict=True)]
    rests = [part.force - of for part, of in zip(parts, linear, strict=True)]
    common = [_common(rest) for rest in rests]
    return LinearApproximation(
        low=np.array([low for low, _ in bands]),
        high=np.array([high for _, high in bands]),
        frequency=np.array([_centre(part) for part in parts]),
        equivalent_damping=np.array([fit.damping for fit in fits]),
        equivalent_damping_error=np.sqrt([fit.damping_variance for fit in fits]),
        apparent_mass=np.array([fit.mass for fit in fits]),
        apparent_mass_error=np.sqrt([fit.mass_variance for fit in fits]),
        coherence=np.array([_coherence(*both) for both in zip(linear, rests, strict=True)]),
        common_psd=np.maximum(common, 0.0),
        own_psd=np.array(
            [np.mean(np.abs(e) ** 2) - max(of, 0.0) for e, of in zip(rests, common, strict=True)]
        ),
        packing_error=_packing_error(parts, fits),
    )


def _within(lines: _Lines, low: float, high: float) -> Flags:
    return np.asarray((lines.frequency >= low) & (lines.frequency < high))


def _bands(lines: _Lines, edges: Array) -> list[tuple[float, float]]:
    """Bands joined from below until each is resolved; what is left joins the last."""
    bands: list[tuple[float, float]] = []
    low = float(edges[0])
    top = float(edges[-1]) * (1 + 1e-9)  # the highest line belongs to it
    ends = [*edges[1:-1].tolist(), top]
    for end in ends:
        part = lines.only(_within(lines, low, end))
        if part.frequency.size < 2:
            continue
        # over C_e of a wider band: over its own, bands would end where that happens to be high
        about = lines.only(_within(lines, low / 2, 2 * end))
        wide = _fit(about, about.force.mean(axis=0)).damping
        own = _fit(part, part.force.mean(axis=0))
        resolved = np.sqrt(own.damping_variance) <= RESOLVED * wide
        if resolved or end > low * WIDEST * (1 - 1e-6):
            bands.append((low, end))
            low = end
    if bands:
        return [*bands[:-1], (bands[-1][0], top)]
    return [(low, top)] if _within(lines, low, top).sum() > 1 else []


def _fit(lines: _Lines, force: Complexes) -> _Fit:
    """Least squares of one force (n,), with variances from the scatter of the lines.

    A residual is smaller than its error by √(1 − h), h the share of its line in the sum (HC2 of
    MacKinnon and White, 1985).
    """
    omega = 2 * np.pi * lines.frequency
    power = np.abs(lines.velocity) ** 2
    damping, damping_share = _ratio(power)
    mass, mass_share = _ratio(omega**2 * power)
    cross = force * lines.velocity.conj()
    c = float(damping * cross.real.sum())
    m = float(mass * (omega * cross.imag).sum())
    rest = cross - (c + 1j * omega * m) * power
    return _Fit(
        c,
        m,
        float(damping**2 * np.sum(rest.real**2 / (1 - damping_share))),
        float(mass**2 * np.sum((omega * rest.imag) ** 2 / (1 - mass_share))),
    )


def _ratio(weight: Array) -> tuple[float, Array]:
    """1/Σ w, and the share of each in it, at most nearly all."""
    total = float(weight.sum())
    if total <= 0:
        raise ValueError("nothing moves in a band")
    return 1 / total, np.minimum(weight / total, 1 - 1e-6)


def _linear(lines: _Lines, fit: _Fit) -> Complexes:
    """Z V (n,)."""
    force: Complexes = (fit.damping + 2j * np.pi * lines.frequency * fit.mass) * lines.velocity
    return force


def _centre(lines: _Lines) -> float:
    power = np.abs(lines.velocity) ** 2
    return float(np.exp(np.sum(power * np.log(lines.frequency)) / power.sum()))


def _coherence(linear: Complexes, rest: Complexes) -> float:
    """Σ|Z V|²/(Σ|Z V|² + Σ|E|²), a packing's mean, from Z V (n,) and E (n_packings, n)."""
    power = float(np.sum(np.abs(linear) ** 2))
    return power / (power + float(np.sum(np.abs(rest) ** 2)) / len(rest))


def _common(rest: Complexes) -> float:
    """Mean of the cross-spectra of each two packings; 0 of a single one."""
    count = len(rest)
    if count < 2:
        return 0.0
    together = np.abs(rest.sum(axis=0)) ** 2 - np.sum(np.abs(rest) ** 2, axis=0)
    return float(together.mean() / (count * (count - 1)))


def _packing_error(parts: Sequence[_Lines], fits: Sequence[_Fit]) -> float:
    """Relative standard error of C_e that comes with few packings.

    The variance of C_e between packings beyond what their own noise explains, with `PACKING`
    counted in. What packings have in common is no part of their differences.
    """
    count = len(parts[0].force)
    weights, excess = [], []
    for part, fit in zip(parts, fits, strict=True) if count > 1 else ():
        if fit.damping <= 0:
            continue
        apart = [_fit(part, force - part.force.mean(axis=0)) for force in part.force]
        between = sum(one.damping**2 for one in apart) / (count - 1) / fit.damping**2
        noise = sum(one.damping_variance for one in apart) / (count - 1) / fit.damping**2
        weights.append((PACKING**2 / (PACKING**2 + noise)) ** 2)
        excess.append(between - noise)
    # bands of the same packings say the same, however many they are
    seen = (count - 1) * max(weights, default=0.0)
    found = seen * float(np.average(excess, weights=weights)) if seen else 0.0
    # mean of the variance under a scaled inverse χ² with all these degrees of freedom
    variance = (PACKING_WEIGHT * PACKING**2 + max(found, 0.0)) / (PACKING_WEIGHT + seen - 2)
    return float(np.sqrt(variance / count))
