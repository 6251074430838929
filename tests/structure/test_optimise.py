"""A search on structures: a flat one in space has the layout of the panel, a curved one its view."""

import numpy as np
import pandas as pd
import pytest
import shapely
import yaml

from pidpanel import Model, StudyError
from pidpanel.check import checked_study
from pidpanel.cli.layouts import write_study
from pidpanel.optimise.from_study import places_of
from pidpanel.optimise.places import overlaps_of
from pidpanel.panel.files import read_plate
from pidpanel.structure.from_study import structure_of
from tests.structures import COMMON, CURVED, NORMAL, PANEL, grid_of, in_space

SEARCH = {
    **{key: value for key, value in COMMON.items() if key != "scenarios"},
    "response": {"frequency_hz": [30, 150]},
    "optimise": {
        "mass_kg": 0.5,
        "patch_size_m": [0.2, 0.2],
        "spacing_m": [0.2, 0.2],
        "patches_at_most": 2,
    },
}


@pytest.fixture(scope="module")
def searched(tmp_path_factory):
    """Models of a panel and of its modes in space, and their proposed places."""
    folder = tmp_path_factory.mktemp("search")
    panel = Model({"name": "flat", "panel": {**PANEL, "patches": {}}, **SEARCH})
    grid_of(panel, np.inf).save(folder / "modes.vtu")
    structure = {
        "modes": {"file": str(folder / "modes.vtu"), "unit_m": 1},
        "mass_kg": 6,
        "outward": NORMAL.tolist(),
        "points": {name: {"at_m": in_space(PANEL["points"][name]).tolist()} for name in ("mid", "off")},
    }  # fmt: skip
    file = folder / "turned.yaml"
    file.write_text(yaml.safe_dump({"structure": structure, **SEARCH}))
    return panel, Model(file), file


def places(model):
    """(n, 2) centres of the best layout."""
    table = pd.read_csv(model._stages.files("optimise").layouts)
    return table[table["layout"] == 1][["centre_x_m", "centre_y_m"]].to_numpy()


def test_a_flat_structure_in_space_has_the_layout_of_the_panel(searched):
    panel, turned, _ = searched
    fronts = [model.optimise().iloc[0] for model in (panel, turned)]
    origin, axes = structure_of(turned.study.panel).view
    found = origin + places(turned) @ axes.T
    wanted = in_space(places(panel))
    order = [np.lexsort(points.T.round(6)) for points in (found, wanted)]
    np.testing.assert_allclose(found[order[0]], wanted[order[1]], atol=1e-9)
    assert len(wanted) == 2
    assert fronts[1]["reduction_db"] == pytest.approx(fronts[0]["reduction_db"], abs=0.02)


def test_the_best_layout_of_a_structure_is_a_study_with_its_patches(searched):
    _, turned, file = searched
    turned.optimise()
    best = file.with_name("best.yaml")
    write_study(file, turned._stages.files("optimise").layouts, best)
    study = checked_study(best)
    middles = []
    structure = structure_of(study.panel)
    for patch in study.all_scenarios()[1].patches:
        cells, area = structure.patches[patch], structure.surface.area
        assert area[cells].sum() == pytest.approx(0.04, rel=0.25)  # of whole elements
        middles.append(np.average(structure.placed(structure.surface.middle[cells]),
                                  axis=0, weights=area[cells]))  # fmt: skip
    assert np.abs(np.sort(middles, axis=0) - np.sort(places(turned), axis=0)).max() < 0.03


def test_patches_are_searched_by_name_and_the_best_layout_names_them(searched, tmp_path):
    *_, file = searched
    structure = yaml.safe_load(file.read_text())["structure"]
    middles = {"corner": [0.2, 0.2], "middle": [0.75, 0.5], "side": [0.75, 0.15]}
    patches = {
        name: {"centre_m": in_space(place).tolist(), "radius_m": 0.12}
        for name, place in middles.items()
    }
    search = {"mass_kg": 5, "patches": list(patches), "patches_at_most": 2}
    values = {**SEARCH, "structure": {**structure, "patches": patches}, "optimise": search}
    study = tmp_path / "listed.yaml"
    study.write_text(yaml.safe_dump(values))
    model = Model(study)
    reduction = model.optimise().iloc[0]["reduction_db"]
    layouts = model._stages.files("optimise").layouts
    table = pd.read_csv(layouts)
    assert set(table[table["layout"] == 1]["patch"]) == {"middle", "side"}
    write_study(study, layouts, tmp_path / "best.yaml")
    best = Model(tmp_path / "best.yaml")
    assert set(best.study.panel.patches) == set(patches)
    assert set(best.study.all_scenarios()[1].patches) == {"middle", "side"}
    rms = best.summary().groupby("scenario", sort=False)["acceleration_rms_g"].max()
    assert 20 * np.log10(rms.iloc[0] / rms.iloc[1]) == pytest.approx(reduction, abs=0.05)


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"patches": ["P", "rim"]}, r"optimise\.patches = .*must be one of patches: P"),
        ({"patches": ["P", "P"]}, r"optimise\.patches = .*has a value twice"),
        ({"patches": ["P"], "patch_size_m": [0.2, 0.2]}, "must have either mass_kg and"),
        ({"patches": ["P"], "spacing_m": [0.2, 0.2]}, "only allowed with patch_size_m"),
    ],
)
def test_patches_that_are_not_there_or_beside_a_grid_are_refused(change, message):
    values = curved()
    values["optimise"] = {"mass_kg": 0.5, **change}
    with pytest.raises(StudyError, match=message):
        Model(values)


def curved(**changed):
    return {"structure": {**CURVED, **changed}, "name": "arch", **SEARCH}


def test_a_place_on_a_curved_surface_has_its_area_there():
    model = Model(curved())
    places, plate = places_of(model.study), read_plate(model._stages.files("panel").plate)
    weight, *_ = overlaps_of(
        places, plate.quadrature_position, plate.quadrature_weight, plate.at_quadrature,
        plate.quadrature_normal,
    )  # fmt: skip
    # a cylinder of radius 1 m about x seen along z: the arc from y0 to y1
    low = places.lower[:, 1]
    area = 0.2 * (np.arcsin(low + 0.2) - np.arcsin(low))
    np.testing.assert_allclose(weight.sum(axis=1), area, rtol=3e-3)
    assert np.ptp(area) > 0.001
    assert np.ptp(np.linalg.norm(places.lower, axis=1)) > 0.3


def test_places_keep_off_supports_and_masses_of_a_shell():
    held = {
        "supports": {"end": {"where": {"from_m": [-1, -2, -2], "to_m": [0.1, 2, 2]}}},
        "masses": {"box": {"at_m": [0.65, 0, 1], "mass_kg": 0.2}},
    }
    found = places_of(Model(curved(shell={**CURVED["shell"], **held})).study)
    assert len(found.lower) < len(places_of(Model(curved()).study).lower)
    boxes = shapely.box(*found.lower.T, *(found.lower + found.size).T)
    assert found.lower[:, 0].min() >= 0.1 - 1e-9
    assert not shapely.contains_properly(boxes, shapely.Point(0.65, 0)).any()


def test_stresses_of_modes_from_a_file_are_no_objective(searched):
    with pytest.raises(StudyError, match=r"optimise\.objective"):
        searched[1].changed({"optimise.objective": "stress"})
