"""Limits beyond which a page doubts a number."""

POWER_BALANCE = 1e-3
"""Share of the power input that may be unaccounted for: a PSD cannot be read more finely."""

MOTION_RESIDUAL = 1e-3
"""|ln(Γ_out/Γ)| from which a motion is not converged: rms values are good to 1e-3."""

BASIS_ERROR = 5e-3
"""Error of a PSD that the shapes of the panel may leave (README)."""
