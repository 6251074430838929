"""The study of the report's tests with coupled runs, and made-up results of them."""

import numpy as np
import pandas as pd

from pidpanel.report.inputs import CoupledResults

COUPON = """
dampers:
  bed:
    particles: {}
    sweep: {fill_fraction: [0.1, 0.9], frequency_hz: [200], acceleration_g: [10]}
damping: {coupled: {relative_error: 0.02}}
"""


def coupled_text(text):
    """Return the study of some text of which every scenario is a coupled run."""
    kept = [line for line in text.splitlines() if not line.startswith("dampers:")]
    return "\n".join(kept) + COUPON


def coupled_results(study, error=0.01):
    """Return results of a study."""
    labels = [one.label for one in study.coupled_scenarios()]
    summary = pd.DataFrame(
        [
            {"scenario": label, "point": point, "g_rms": 10.0, "g_rms_error": 10 * error,
             "linear_g_rms": 8.0, "recorded_g_rms": 11.0, "residual_db": sign * 0.2, "runs": 2}
            for label in labels
            for sign, point in enumerate(study.panel.points)
        ]
    )  # fmt: skip
    frequency = np.array([100.0, 200.0, 400.0])
    impedance = pd.concat(
        pd.DataFrame(
            {"scenario": one.label, "patch": patch, "band_hz": frequency,
             "frequency_hz": 1.01 * frequency,
             "equivalent_damping_n_s_m3": [300.0, 100.0, -5.0],
             "equivalent_damping_error_n_s_m3": 20.0, "apparent_mass_kg_m2": 2.0,
             "apparent_mass_error_kg_m2": 0.2, "particle_mass_per_area_kg_m2": 6.7,
             "youngs_modulus_mpa": 200.0}
        )
        for one in study.coupled_scenarios() for patch in one.fillings
    )  # fmt: skip
    return CoupledResults(summary, impedance)
