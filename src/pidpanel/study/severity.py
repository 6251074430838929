"""The section ``severity`` of a study: what is read off the responses beside rms values."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Annotated

from pidpanel.study.base import SectionModel
from pidpanel.study.mistakes import Mistake
from pidpanel.study.quantity import MEGAPASCAL, Quantity

LEAST_CYCLES = 100.0
"""Least product of the lowest frequency and the duration: the largest peak of fewer cycles is not
that of its formula."""


class Fatigue(SectionModel):
    """An S-N line N = cycles (A/stress_mpa)^−exponent for the amplitude A, at zero mean stress."""

    stress_mpa: Annotated[float, Quantity(0.1, 5000, units=MEGAPASCAL)]
    """Amplitude, half the range, at which failure takes ``cycles`` [MPa]."""
    cycles: Annotated[float, Quantity(1, 1e12)] = 1e6
    """Cycles to failure at that amplitude."""
    exponent: Annotated[float, Quantity(1, 30)]
    """b of the line: 4 to 10 for metals."""


class Severity(SectionModel):
    """Oscillator spectra, peaks in a duration, fatigue."""

    quality: Annotated[float, Quantity(1, 1000)] = 10.0
    """Q of the oscillators of the vibration response spectrum, 1/2ζ."""
    duration_s: Annotated[float, Quantity(0.1, 1e7)] = 60.0
    """Duration of the sound at its level, for peaks and damage [s]."""
    fatigue: Fatigue | None = None
    """S-N line of the stresses at the points; without it, no damage is computed."""


def mistakes_of_severity(severity: Severity | None, lowest: float) -> Iterator[Mistake]:
    """Yield a duration of too few cycles of the lowest frequency [Hz]."""
    if severity is not None and severity.duration_s * lowest < LEAST_CYCLES:
        yield Mistake(
            ("severity", "duration_s"),
            f"must be at least {LEAST_CYCLES / lowest:.3g}, {LEAST_CYCLES:g} cycles of the lowest "
            "frequency of the response",
        )
