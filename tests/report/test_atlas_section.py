"""The atlas on the page: its source, and curves of the patches that are read from it."""

import numpy as np
import pandas as pd

from pidpanel.damping.models import DampingValues
from pidpanel.report import style
from pidpanel.report.coupled_section import atlas_section, curves
from pidpanel.report.inputs import AtlasResults
from tests.page_reader import blocks_of


class Model:
    """C_e = Γ r f, known to a tenth, to 1 kHz; m_a of 2 ± 0.5 kg/m²."""

    def __call__(self, frequency, fill, gamma):
        damping = gamma * fill * frequency
        return DampingValues(damping, 0.1 * damping, 2 + 0 * frequency, frequency <= 1000)

    def covariance(self, frequency, fill, gamma):
        return np.diag([0.01] * len(frequency) + [0.25] * len(frequency))


ATLAS = AtlasResults("version 0.1.0, 873 simulated cases", {"steel": Model()})
LAYOUTS = pd.DataFrame(
    {
        "scenario": ["a", "a"],
        "patch": ["P1", "P2"],
        "damper": ["steel", "lab"],
        "fill_fraction": [0.5, np.nan],
        "damping_read_at_g": [20.0, 3.0],
    }
)


def test_curves_are_of_the_patches_read_from_the_atlas_at_their_motion():
    table = curves(ATLAS, LAYOUTS, (100.0, 2000.0))
    assert set(table["patch"]) == {"P1"} and table["frequency_hz"].max() <= 1000
    np.testing.assert_allclose(table["equivalent_damping_n_s_m3"], 10 * table["frequency_hz"])
    np.testing.assert_allclose(table["equivalent_damping_error_n_s_m3"], table["frequency_hz"])
    assert (table["apparent_mass_error_kg_m2"] == 0.5).all()


def test_a_patch_outside_the_atlas_at_all_frequencies_leaves_a_section_without_curves():
    with style.context():
        section = atlas_section(ATLAS, LAYOUTS, {"a": "A"}, (1500.0, 2000.0), is_coupled=False)
    assert not section.pictures
    assert "outside the range of the atlas" in blocks_of(section)[1].text
