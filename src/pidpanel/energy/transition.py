"""From the modal answer to statistical energy: where, and how well the PSD of a point is known."""

from typing import NamedTuple

import numpy as np

from pidpanel.arrays import Array, Flags
from pidpanel.energy.response import EnergyResponse, relative_variance

LEAST_MODES = 5.0  # in a third octave
AGREEMENT_DB = 1.0  # between both answers in each third of the octave of transition
OCTAVE = 3  # third octaves
THIRD = 10**0.05 - 10**-0.05  # width of a third octave over its centre
COINCIDENCE_DB = 2.0  # standard error of a band at coincidence: 1.0 to 2.3 dB on three panels

# A damper is heavy above: it reflects waves, and its patch moves less than the panel.
HEAVY_MASS = 0.5  # m_a/m″
HEAVY_DAMPING = 0.2  # C_e/(m″ ω)


class Factors(NamedTuple):
    """Spread among the modes: ⟨x²⟩/⟨x⟩²."""

    force: float  # of the modal force in the sound, over ∫φ² dA
    shape: float  # of φ² over the panel, the mean of the modes


class Bands(NamedTuple):
    """Third octaves of a scenario, all (n,)."""

    centre: Array  # [Hz]
    modes: Array  # in the band, by their density
    difference_db: Array  # energy over modal, area mean; NaN beyond the modal answer
    at_coincidence: Flags
    is_known: Flags  # see `EnergyResponse`
    mean_error: Array  # standard error of ln of the area mean
    point_error: Array  # standard error of ln of the value at a point


def factors_of(modal_force: Array, overlap: Array, shape: Array, area: Array) -> Factors:
    """Return the factors of modes.

    Parameters
    ----------
    modal_force
        (n,) G_ii [m⁴].
    overlap
        (n,) ∫φ_i² dA [m²].
    shape
        (n_places, n) φ at places.
    area
        (n_places,) their areas [m²].
    """
    force = modal_force / overlap
    square = area @ shape**2
    share = (area @ shape**4) * area.sum() / square**2
    return Factors(float(np.mean(force**2) / np.mean(force) ** 2), float(np.mean(share)))


def band_errors(
    centre: Array, energy: EnergyResponse, factors: Factors, damping_error: Array
) -> tuple[Array, Array]:
    """Return standard errors (n,) of ln S of the area mean and at a point, in third octaves.

    ``damping_error`` (n,) is the standard error of ln η_d.
    """
    modes = energy.modal_density * centre * THIRD
    coincident = energy.at_coincidence * COINCIDENCE_DB * np.log(10) / 10
    by_dampers = damping_error * energy.damper_loss_factor / energy.loss_factor
    errors = []
    for factor in (factors.force, factors.force * factors.shape):
        variance = relative_variance(modes, energy.loss_factor, factor, THIRD)
        spread = energy.resonant_share**2 * np.log1p(variance)
        errors.append(np.sqrt(spread + coincident**2 + by_dampers**2))
    return errors[0], errors[1]


def objection(bands: Bands) -> str:
    """Return why the last octave below the end of the modal answer is none of transition; or ""."""
    compared = np.flatnonzero(np.isfinite(bands.difference_db))[-OCTAVE:]
    if len(compared) < OCTAVE:
        return "the modal answer has less than an octave of whole third octaves"
    for band in compared.tolist():
        at = f"at {bands.centre[band]:.4g} Hz"
        if bands.modes[band] < LEAST_MODES:
            return f"{bands.modes[band]:.2g} modes {at}; at least {LEAST_MODES:g} are needed"
        if bands.at_coincidence[band]:
            return f"coincidence {at}"
        if not bands.is_known[band]:
            return f"radiation of free edges below coincidence, {at}, is not known"
        if abs(difference := bands.difference_db[band]) > AGREEMENT_DB:
            return f"{difference:.2g} dB between both answers {at}; at most {AGREEMENT_DB:g}"
    return ""


def heavy(frequency: Array, damping: Array, mass: Array, mass_per_area: float) -> str:
    """Return why a damper is too heavy, (nf,) of frequency, C_e and m_a; "" where it is not."""
    if (ratio := mass / mass_per_area).max(initial=0.0) > HEAVY_MASS:
        f = frequency[ratio.argmax()]
        return f"heavy: m_a/m″ = {ratio.max():.2g} at {f:.4g} Hz; at most {HEAVY_MASS:g}"
    if (ratio := damping / (mass_per_area * 2 * np.pi * frequency)).max() > HEAVY_DAMPING:
        f = frequency[ratio.argmax()]
        return f"heavy: C_e/(m″ω) = {ratio.max():.2g} at {f:.4g} Hz; at most {HEAVY_DAMPING:g}"
    return ""


def energy_share(frequency: Array, low: float, high: float) -> Array:
    """Return the share of statistical energy in the PSD, smooth from 0 at low to 1 at high [Hz].

    Examples
    --------
    >>> energy_share(np.array([500.0, 1000.0, 2000.0, 4000.0]), 500.0, 2000.0).round(12).tolist()
    [0.0, 0.5, 1.0, 1.0]
    """
    x = np.clip(np.log(frequency / low) / np.log(high / low), 0.0, 1.0)
    return np.asarray(x**2 * (3 - 2 * x))
