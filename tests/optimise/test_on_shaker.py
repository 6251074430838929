"""Proposed layouts of a panel on a shaker against the stage that computes base motion."""

import numpy as np
import pandas as pd
import pytest
import yaml

from pidpanel.base.from_study import write_base
from pidpanel.optimise.from_study import write_proposal
from pidpanel.panel.files import read_basis
from pidpanel.sound.from_study import write_sound
from pidpanel.structure.from_study import write_panel
from pidpanel.study import load_study
from tests.jobs import PANEL, SOUND, files, within

NAMES = ("layouts", "front", "summary", "search", "psd")
STUDY = """
dampers: {rubber: {equivalent_damping_n_s_m3: 700, apparent_mass_kg_m2: 6}, acrylic: {table: acrylic_2mm.csv}}
panel:
  outline_m: [1.5, 1.0]
  section: {kind: thin, mass_per_area_kg_m2: 4.0, bending_stiffness_n_m: 3273.07, thickness_mm: 25}
  supports: simply_supported
  damping_ratio: 0.02
  mesh: {kind: quadrilaterals, elements: [15, 10]}
  points: {centre: [0.7, 0.5], aside: [0.3, 0.3]}
base: {random: {spectrum: gevs_acceptance.csv}}
response: {frequency_hz: [30, 300]}
optimise: {mass_kg: 0.6, patch_size_m: [0.2, 0.2], spacing_m: [0.3, 0.2], patches_at_most: 2, fill_fraction: [0.9]}
"""


def run(folder, study, **more):
    """Run the panel and the search of a study; return its tables by name."""
    study.write_text(yaml.safe_dump(more))
    loaded, panel = load_study(study), folder / "panel"
    panel.mkdir(exist_ok=True)
    write_panel(loaded, files(within(panel, PANEL)))
    return loaded, panel


@pytest.fixture(scope="module")
def stages(tmp_path_factory):
    """A study, its panel and its sound."""
    folder = tmp_path_factory.mktemp("on_shaker")
    file = folder / "study.yaml"
    values = yaml.safe_load(STUDY) | {"sound": {"spectrum": "smc_s_016_2014_min_third.csv"}}
    loaded, panel = run(folder, file, **values)
    basis = read_basis(panel / "modes.nc")
    write_sound(loaded, basis, files(within(folder, SOUND)))
    return values, panel, folder / "modal_force.nc"


def designed(stages, folder, **keys):
    """Tables of the search with other keys of ``optimise``."""
    values, panel, force = stages
    values = values | {"optimise": values["optimise"] | keys}
    file = folder / "design.yaml"
    if keys["excitation"] == "base":
        values = {key: part for key, part in values.items() if key != "sound"}
        force = None
    file.write_text(yaml.safe_dump(values))
    read = files(within(panel, PANEL) | {"modal_force": force})
    made = files({name: folder / f"{name}.csv" for name in NAMES})
    write_proposal(load_study(file), read, None, made)
    return {name: pd.read_csv(folder / f"{name}.csv") for name in NAMES}


def test_the_best_layout_moves_as_the_base_stage_says(stages, tmp_path):
    tables = designed(stages, tmp_path, excitation="base")
    front, best = tables["front"], tables["layouts"].query("layout == 1")
    assert set(front["excitation"]) == {"base"} and front["reduction_db"].iloc[0] > 2
    assert (front["search_reduction_db"] - front["reduction_db"]).abs().max() < 0.3
    values = stages[0]
    patches = {
        f"P{k}": {"centre_m": [row.centre_x_m, row.centre_y_m], "size_m": [0.2, 0.2]}
        for k, row in enumerate(best.itertuples())
    }
    layout = {
        f"P{k}": {"damper": row.damper}
        | ({} if np.isnan(row.fill_fraction) else {"fill_fraction": row.fill_fraction})
        for k, row in enumerate(best.itertuples())
    }
    values = {key: part for key, part in values.items() if key not in ("optimise", "sound")}
    values["panel"] = values["panel"] | {"patches": patches}
    values["scenarios"] = {"best": {"layout": layout}}
    study, on_panel = run(tmp_path, tmp_path / "best.yaml", **values)
    outputs = {"modes_table": "m.csv", "summary": "s.csv", "psd": "p.nc", "psd_table": "p.csv"}
    write_base(
        study,
        files(within(on_panel, PANEL)),
        None,
        files(within(tmp_path, outputs)),
    )
    base = pd.read_csv(tmp_path / "s.csv").set_index(["scenario", "point"])
    summary = tables["summary"].query("layout == 1").set_index("point")
    for scenario, column in (("bare", "bare_rms_g"), ("best", "acceleration_rms_g")):
        for point in ("centre", "aside"):
            expected = base.loc[(scenario, point), "acceleration_rms_g"]
            assert summary.loc[point, column] == pytest.approx(expected, rel=2e-3)
    errors = base.loc["best", "acceleration_rms_error_g"]
    assert summary["acceleration_rms_error_g"].to_numpy() == pytest.approx(
        errors[summary.index].fillna(0).to_numpy(), rel=0.02, abs=1e-3
    )


def test_of_both_excitations_the_smaller_reduction_is_stated(stages, tmp_path):
    tables = designed(stages, tmp_path, excitation="both")
    front = tables["front"]
    both = front[["sound_reduction_db", "base_reduction_db"]]
    np.testing.assert_allclose(front["reduction_db"], both.min(axis=1), atol=1e-4)
    assert (both.max(axis=1) - both.min(axis=1)).max() > 0.1
    assert set(tables["summary"]["excitation"]) == {"sound", "base"}
    assert np.isfinite(tables["search"].set_index("quantity").loc["gap_db", "value"])
