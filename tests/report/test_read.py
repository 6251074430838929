"""Records hold what the files of the stages hold."""

from itertools import product

import numpy as np
import pandas as pd
import pytest
from coupled_study import coupled_results

from pidpanel.damping import fit, surface_files
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_cases import ERROR, VALUE
from pidpanel.report.from_study import read_coupon
from pidpanel.report.inputs import read_coupled, read_damping
from pidpanel.study import StudyError, load_study

DAMPING = """
dampers:
  beads:
    model: tones
    cell: {depth_mm: 30}
    particles: {}
    sweep: {fill_fraction: [0.1, 0.6, 0.9], frequency_hz: [50, 150, 450], acceleration_g: [5, 50]}
"""


@pytest.fixture
def dem(tmp_path, study_text):
    path = tmp_path / "dem.yaml"
    lines = [line for line in study_text.splitlines() if not line.startswith("dampers:")]
    path.write_text("\n".join(lines) + DAMPING)
    return load_study(path)


@pytest.fixture
def folder(tmp_path):
    """What coupon and damping leave: cases of C_e = r f √(5/Γ).

    A form that fits without any residual has no information criterion: C_e is off by 0.1 %.
    """
    off = 1 + 1e-3 * np.random.default_rng(0).normal(size=18)
    cases = pd.DataFrame(
        [
            {"case": f"r{r}_f{f}Hz_a{a}g", "fill_fraction": r, "frequency_hz": float(f),
             "acceleration_g": float(a), "particle_mass_per_area_kg_m2": 14 * r,
             VALUE: r * f * (5 / a) ** 0.5 * off[index], ERROR: 0.02 * r * f, "apparent_mass_kg_m2": 0.1 * r,
             "status": "ok"}
            for index, (r, f, a) in enumerate(product((0.1, 0.6, 0.9), (50, 150, 450), (5, 50)))
        ]
    )  # fmt: skip
    surface = DampingSurface.from_frame(cases)
    for name in ("coupon", "damping"):
        (tmp_path / name).mkdir()
    cases.to_csv(tmp_path / "coupon" / "cases.csv", index=False)
    surface_files.to_dataset(surface).to_netcdf(tmp_path / "damping" / "surface.nc", engine="scipy")
    law = fit.fit_accelerations(surface.cases)
    law.to_csv(tmp_path / "damping" / "law.csv", index=False)
    return tmp_path


def test_the_damping_of_a_study_is_read_whole(folder):
    found = read_damping("coupon", folder)
    assert len(found.surface.cases) == 18
    assert {"constant", "value", "low", "high"} <= set(found.law.columns)
    value = found.surface([150.0], 0.6, 5.0).equivalent_damping
    # the surface passes through its cases within their error of 2 %, twice
    assert value == pytest.approx(0.6 * 150, rel=0.04)


def test_cases_need_the_section_of_the_coupon(dem, folder):
    with pytest.raises(StudyError, match="dem: no coupon named"):
        read_coupon(dem.model_copy(update={"coupon": None}), "coupon", folder)


@pytest.mark.parametrize("others", [True, False])
def test_coupled_runs_have_a_verdict_only_beside_other_models(coupled_study, tmp_path, others):
    found = coupled_results(coupled_study)
    for name in ("summary", "impedance"):
        getattr(found, name).assign(patch="1").to_csv(tmp_path / f"{name}.csv", index=False)
    pd.DataFrame({"scenario": ["2"], "point": ["3"]}).to_csv(tmp_path / "verdict.csv")
    read = read_coupled(tmp_path, with_verdict=others)
    assert (read.verdict is not None) == others
    # names that look like numbers stay names
    assert set(read.impedance["patch"]) == {"1"}
    assert read.summary["runs"].tolist() == [2] * len(found.summary)
