"""The damping on the page says what its tables hold."""

import re

import numpy as np
import pandas as pd
import pytest

from pidpanel.damping import fit
from pidpanel.damping.laws import equation_5
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import ERROR, VALUE
from pidpanel.report import style
from pidpanel.report.damping_section import damping_section
from pidpanel.report.inputs import DampingResults
from tests.page_reader import blocks_of

TRUE = np.array([np.log(20.0), 0.8, -0.3, 1.9, -0.2, 1e-5, -5e-6])


@pytest.fixture(scope="module")
def results():
    """Cases of a law in the paper's form, which falls with Γ: 3 fills, 4 frequencies, 2 levels."""
    r, f, level = (
        g.ravel()
        for g in np.meshgrid([0.2, 0.5, 0.8], [50, 150, 450, 1300], [5, 50], indexing="ij")
    )
    a1, a2, a3 = fit.constants_at(r, TRUE)
    noise = np.exp(0.02 * np.random.default_rng(0).normal(size=24))
    value = equation_5(2 * np.pi * f, a1, a2, a3) * (level / 5.0) ** -0.8 * noise
    cases = pd.DataFrame(
        {"fill_fraction": r, "frequency_hz": f, "acceleration_g": level.astype(float),
         VALUE: value, ERROR: 0.02 * value, "particle_mass_per_area_kg_m2": 14 * r,
         "apparent_mass_kg_m2": 0.1 * r, "status": "ok",
         "normal_share": 0.6, "tangential_share": 0.4}
    )  # fmt: skip
    surface = DampingSurface.from_frame(cases)
    law = fit.fit_accelerations(surface.cases)
    return DampingResults(surface, law)


@pytest.fixture(scope="module")
def section(results):
    with style.context():
        return damping_section(results)


def test_every_level_has_its_constants_with_intervals_that_hold_them(section):
    (table,) = (
        b for b in blocks_of(section) if b.kind == "table" and "in the form of Eq. 6" in b.caption
    )
    assert [row[0] for row in table.rows] == ["5", "50"]
    low, high = re.search(r"\[([\d.]+), ([\d.]+)\]", table.rows[0][4]).groups()
    assert float(low) < 1.9 < float(high)


def test_a_level_with_cases_of_one_fill_has_no_law_over_fill(results):
    alone = results.law[results.law["fill_fraction"].notna()].iloc[:3]
    tones = alone.assign(acceleration_g=512.0)
    law = pd.concat([results.law, tones, tones.assign(fill_fraction=np.nan, scatter=0.0)])
    with style.context():
        blocks = blocks_of(damping_section(results._replace(law=law)))
    tables = [b for b in blocks if b.kind == "table" and "over fill" in b.caption.lower()]
    assert all(row[0] != "512" for table in tables for row in table.rows)
    (text,) = (b.text for b in blocks if b.kind == "paragraph" and "a₂ =" in b.text)
    assert "Γ = 512" not in text
