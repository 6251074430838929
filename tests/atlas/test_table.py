"""The published table is what its description says, and agrees with itself."""

import csv
import json
import math
from pathlib import Path

import pytest
import yaml

from pidpanel.atlas.groups import Direction
from pidpanel.atlas.table import PACKAGE_FILE, TABLE_FILE, fields, read_atlas
from pidpanel.damping import atlas_files

G = 9.80665


ROOT = Path(__file__).parents[2]


@pytest.fixture(scope="module")
def atlas():
    return read_atlas()


def test_columns_with_a_dimension_have_it_in_their_name():
    suffixes = {"mm": "_mm", "Hz": "_hz", "MPa": "_mpa", "kg/m³": "_kg_m3", "kg/m²": "_kg_m2",
                "N s/m³": "_n_s_m3", "1": ""}  # fmt: skip
    for field in fields():
        if field["type"] in ("number", "integer"):
            assert field["name"].endswith(suffixes[field["unit"]]), field["name"]
        assert field["description"].endswith(".")
    (direction,) = (field for field in fields() if field["name"] == "direction")
    assert tuple(direction["constraints"]["enum"]) == Direction.__args__


def test_archive_and_citation_are_of_the_published_version():
    package, archive = (
        json.loads(path.read_text(encoding="utf-8"))
        for path in (PACKAGE_FILE, ROOT / ".zenodo.json")
    )
    cited = yaml.safe_load((ROOT / "CITATION.cff").read_text(encoding="utf-8"))
    (data,) = (entry for entry in cited["references"] if entry["type"] == "data")
    assert package["version"] == archive["version"] == data["version"]
    assert package["title"] == archive["title"] == data["title"]
    assert package["licenses"][0]["name"].lower() == archive["license"] == data["license"].lower()
    assert archive["creators"] == cited["authors"] == data["authors"]
    assert f"version {package['version']}. CC BY 4.0" in (ROOT / "docs" / "cite.md").read_text()


def test_groups_follow_from_the_simulated_values(atlas):
    omega = 2 * math.pi * atlas["frequency_hz"]
    gap = (1 - atlas["fill_fraction"]) * atlas["depth_mm"] * 1e-3
    for name, values in {
        "stroke_per_gap": atlas["gamma"] * G / omega**2 / gap,
        "width_per_diameter": atlas["across_flats_mm"] / atlas["diameter_mm"],
        "depth_per_diameter": atlas["depth_mm"] / atlas["diameter_mm"],
        "hardness": atlas["density_kg_m3"] * (atlas["gamma"] * G / omega) ** 2
        / (1e6 * atlas["youngs_modulus_mpa"]),
    }.items():  # fmt: skip
        # six digits are written
        assert (atlas[name] / values - 1).abs().max() < 1e-4, name


def test_dimensionless_results_are_those_in_si(atlas):
    scale = atlas["particle_mass_per_area_kg_m2"] * 2 * math.pi * atlas["frequency_hz"]
    for name, value in {
        "loss_factor": "equivalent_damping_n_s_m3",
        "loss_factor_error": "equivalent_damping_error_n_s_m3",
    }.items():
        known = atlas[value] != 0
        assert (atlas[name] * scale / atlas[value] - 1)[known].abs().max() < 1e-4
    mass = atlas["mass_ratio"] * atlas["particle_mass_per_area_kg_m2"]
    assert (mass - atlas["apparent_mass_kg_m2"]).abs().max() < 1e-4 * mass.abs().max()


def test_states_are_listed_with_their_shares(atlas):
    for _, row in atlas[atlas["states"] > 1].iterrows():
        values = [float(value) for value in row["state_loss_factors"].split()]
        shares = [float(share) for share in row["state_shares"].split()]
        assert len(values) == len(shares) == row["states"]
        assert sum(shares) == pytest.approx(1, abs=1e-3)
        assert values == sorted(values)
    single = atlas[atlas["states"] == 1]
    assert (single["state_loss_factors"] == "").all()


def test_values_are_those_that_the_description_allows(atlas):
    assert list(atlas) == [field["name"] for field in fields()]
    for field in fields():
        values, allowed = atlas[field["name"]], field.get("constraints", {})
        assert not (allowed.get("required") and (values.isna() | (values == "")).any())
        assert values.isin(allowed.get("enum", values)).all()
        assert (values >= allowed.get("minimum", values)).all() or "minimum" not in allowed
        assert (values <= allowed.get("maximum", values)).all() or "maximum" not in allowed
        assert values.is_unique or not allowed.get("unique")


def test_pages_count_the_cases_of_the_file():
    with TABLE_FILE.open(newline="") as file:
        count = sum(1 for _ in csv.DictReader(file))
    atlas = atlas_files.read_atlas()
    text = atlas_files.version_text(atlas)
    assert f"{count} simulated cases, {len(atlas.cases)} of them" in text
    assert len(atlas.cases) < count
