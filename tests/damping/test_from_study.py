"""The dampers of a study: each its own damping model, none in place of another."""

from typing import get_args

import numpy as np
import pandas as pd
import pytest
import yaml
from pydantic import TypeAdapter

from pidpanel.columns import ColumnsError
from pidpanel.damping.atlas import AtlasDamping
from pidpanel.damping.from_study import damper_model, dampers_of
from pidpanel.damping.laws import ConstantDamper, paper_corrected, paper_printed
from pidpanel.damping.models import DampingError
from pidpanel.damping.surface import DampingSurface
from pidpanel.damping.surface_files import to_dataset
from pidpanel.paths import STUDIES
from pidpanel.study import StudyError, load_study
from pidpanel.study.dampers import AnyDamper, Prior

DAMPER = TypeAdapter(AnyDamper)


def damper(**values):
    return damper_model(DAMPER.validate_python(values))


def test_constants_are_a_damper():
    found = damper(equivalent_damping_n_s_m3=2000, equivalent_damping_error_n_s_m3=100,
                   apparent_mass_kg_m2=3, apparent_mass_error_kg_m2=0.2,
                   particle_mass_per_area_kg_m2=4)  # fmt: skip
    assert found == ConstantDamper(2000, 0.0, 0.05, 3.0, 0.2, 4.0)
    assert damper(equivalent_damping_n_s_m3=0, apparent_mass_kg_m2=3) == ConstantDamper(
        apparent_mass=3.0
    )


def test_a_loss_factor_is_that_of_the_particles_or_of_the_patch():
    of_bed = damper(loss_factor=0.2, loss_factor_error=0.05, particle_mass_per_area_kg_m2=3)
    assert of_bed == ConstantDamper(loss_mass=0.2 * 3, relative_error=0.25, weight=3.0)
    of_patch = damper(loss_factor=0.1, patch_mass_per_area_kg_m2=5, apparent_mass_kg_m2=1,
                      particle_mass_per_area_kg_m2=2)  # fmt: skip
    assert of_patch == ConstantDamper(loss_mass=0.5, apparent_mass=1.0, weight=2.0)


def test_a_law_is_a_damper():
    found = damper(law="paper_corrected")(np.array([100.0]), 0.5, 1.0)
    assert found.equivalent_damping == paper_corrected(100.0, 0.5)
    found = damper(law="paper_printed")(np.array([100.0]), 0.5, 1.0)
    assert found.equivalent_damping == paper_printed(100.0, 0.5)


def test_a_table_and_an_impedance_are_read_as_the_damper_says(tmp_path):
    bent = tmp_path / "bent.csv"
    bent.write_text("frequency_hz,equivalent_damping_n_s_m3,apparent_mass_kg_m2\n"
                    "100,10,1\n400,160,1\n")  # fmt: skip
    for kind in ("table", "impedance"):
        for interpolation, value in ((None, 40.0), ("log", 40.0), ("linear", 60.0)):
            found = damper(**{kind: bent, "interpolation": interpolation})
            assert found(np.array([200.0]), 0.5, 1.0).equivalent_damping == pytest.approx(value)
    real = tmp_path / "real.csv"
    real.write_text("frequency_hz,equivalent_damping_n_s_m3\n100,10\n")
    damper(table=real)
    with pytest.raises(ColumnsError, match="apparent_mass_kg_m2: missing"):
        damper(impedance=real)


@pytest.mark.parametrize("model", ["tones", "coupled"])
def test_simulated_damping_without_its_runs_is_no_other_one(model):
    with pytest.raises(DampingError, match="its runs are missing"):
        damper(particles={}, model=model)


def test_particles_without_mass_are_dashpots_in_every_model(tmp_path, write_study, table_values):
    values = table_values()
    values["dampers"]["bed"] = {"particles": {}, "model": "atlas"}
    for scenario in values["scenarios"].values():
        scenario["damper"] = ["lab", "bed"]
    masses = []
    for has_mass in (True, False):
        values["response"]["damper_mass"] = has_mass
        study = load_study(write_study(tmp_path, "table", values))
        models = dampers_of(study)
        assert sorted(models) == ["bed", "lab"]
        read = [model(np.array([80.0]), 0.5, 30.0) for model in models.values()]
        masses.append([abs(one.apparent_mass.item()) for one in read])
        assert all(one.equivalent_damping > 0 for one in read)
    assert min(masses[0]) > 0 and masses[1] == [0.0, 0.0]


@pytest.fixture(scope="module")
def coupon():
    """A coupon of steel in cells that the atlas has no packing of."""
    return {
        "cell": {"shape": "hexagon", "across_flats_mm": 9, "depth_mm": 30},
        "particles": {"diameter_mm": 2, "density_kg_m3": 7850, "restitution": 0.55,
                      "friction": 0.15},
        "sweep": {"fill_fraction": [0.4], "frequency_hz": [200], "acceleration_g": [30]},
    }  # fmt: skip


def test_the_prior_of_a_surface_is_the_one_that_is_named(coupon, tmp_path):
    # four cases of C_e as the atlas has it, but for one; between them they say little alone
    atlas = damper_model(DAMPER.validate_python({**coupon, "model": "atlas"}), is_broadband=False)
    frequency = np.array([100.0, 200.0, 500.0, 1000.0])
    damping = atlas(frequency, 0.4, 30.0).equivalent_damping * [1, 1, 1, 2]
    surface = DampingSurface.from_frame(
        pd.DataFrame(
            {
                "fill_fraction": 0.4, "frequency_hz": frequency, "acceleration_g": 30.0,
                "equivalent_damping_n_s_m3": damping,
                "equivalent_damping_error_n_s_m3": 0.03 * damping,
                "apparent_mass_kg_m2": -0.5, "apparent_mass_error_kg_m2": 0.5,
                "particle_mass_per_area_kg_m2": 1.1 * atlas.mass_per_area(0.4),
            }
        ),
        1.0,
        30e-3,
    )  # fmt: skip
    to_dataset(surface).to_netcdf(tmp_path / "surface.nc", engine="scipy")
    own, with_atlas = (
        damper_model(
            DAMPER.validate_python({**coupon, "model": "tones", "prior": prior}),
            tmp_path / "surface.nc",
        )
        for prior in get_args(Prior)
    )
    assert isinstance(own, DampingSurface) and isinstance(with_atlas, AtlasDamping)
    assert with_atlas.mass_per_area(0.4) == pytest.approx(1.1 * atlas.mass_per_area(0.4))
    between = np.array([330.0, 700.0])
    values = [model(between, 0.4, 30.0) for model in (own, with_atlas, atlas)]
    errors = [v.equivalent_damping_error / v.equivalent_damping for v in values]
    assert (errors[1] < errors[0]).all() and (errors[1] < errors[2]).all()
    at_case = with_atlas(frequency[-1:], 0.4, 30.0).equivalent_damping
    assert at_case == pytest.approx(damping[-1], rel=0.2)


def test_a_surface_starts_from_the_atlas_only_inside_it(tmp_path):
    values = yaml.safe_load((STUDIES / "level.yaml").read_text(encoding="utf-8"))
    values["dampers"]["tones"]["prior"] = "atlas"
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(values))
    beds = load_study(tmp_path / "study.yaml").beds("tones")
    assert [name for name, bed in beds.items() if bed.is_of_atlas] == ["tones"]
    values["dampers"]["acrylic"]["particles"]["restitution"] = 0.99
    (tmp_path / "study.yaml").write_text(yaml.safe_dump(values))
    with pytest.raises(StudyError, match=r"in the range of the atlas, 0\.3 to 0\.95"):
        load_study(tmp_path / "study.yaml")
