"""The page of an identification: the particles, and measured values beside those of the atlas."""

from __future__ import annotations

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.identify.from_study import IdentificationResult, summary
from pidpanel.report.text import number, records

SYMBOLS = {"restitution": "e", "friction": "μ", "fill_fraction": "r"}


def answer_lines(result: IdentificationResult) -> list[str]:
    """Return the answer in lines: the particles first."""
    posterior = result.posterior
    lines = []
    if not posterior.is_explained:
        lines.append(f"No particles of the atlas explain the measurement: {_fit(result)}.")
    for row in records(summary(posterior)):
        ends = f"{row['low_90']:.3g} to {row['high_90']:.3g}"
        text = f"{SYMBOLS[row['parameter']]} = {row['value']:.3g} (90 %: {ends})"
        cut = [end for end in ("low", "high") if row[f"cut_{end}"]]
        if cut:
            text += f"; cut at the {' and '.join(cut)} end of the atlas"
        lines.append(text)
    lines.append(f"correlation of e and ln μ: {posterior.correlation[0, 1]:+.2f}")
    if posterior.is_explained:
        lines.append(f"These particles explain the measurement: {_fit(result)}.")
    return [*lines, next_line(result)]


def _fit(result: IdentificationResult) -> str:
    return f"χ² = {number(result.posterior.least_chi_square)} of {result.posterior.count} values"


def next_line(result: IdentificationResult) -> str:
    """Return the further tone that tells most."""
    further, rows = result.further, summary(result.posterior)
    if not len(further.frequency):
        return "The shaker cannot run a further tone."
    best = further.best
    f, gamma = further.frequency[best], further.acceleration_g[best]
    stroke = gamma * STANDARD_GRAVITY / (2 * 3.141592653589793 * f) ** 2 * 1e3
    return (
        f"A further tone at {f:.3g} Hz and {gamma:.3g} g ({stroke:.2g} mm) would narrow most: "
        f"standard deviation of e from {rows['error'][0]:.2g} to "
        f"{further.restitution_error[best]:.2g}, of μ from "
        f"{100 * rows['error'][1] / rows['value'][1]:.0f} to "
        f"{100 * further.friction_error[best]:.0f} %."
    )
