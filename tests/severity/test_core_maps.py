"""Failure indices over a sandwich panel, from its study to their maps."""

import numpy as np
import pandas as pd
import pytest
import xarray as xr

from tests.jobs import RESPONSE, call, make_panel, make_sound, within

STUDY = """
panel:
  outline_m: [0.9, 0.6]
  section:
    kind: sandwich
    materials: {foil: {youngs_modulus_gpa: 70, poissons_ratio: 0.33, density_kg_m3: 2700}}
    faces: [{material: foil, thickness_mm: 0.3}]
    core:
      {shear_modulus_l_mpa: 186, shear_modulus_w_mpa: 90, density_kg_m3: 32, thickness_mm: 20}
  supports: simply_supported
  damping_ratio: 0.02
  mesh: {kind: triangles, size_m: 0.12}
  points: {inside: [0.3, 0.2], middle: [0.4, 0.3]}
sound: {spectrum: flat.csv}
response: {frequency_hz: [100, 400]}
severity:
  strength:
    layers: {tension_1_mpa: 300, compression_1_mpa: 300, tension_2_mpa: 300,
             compression_2_mpa: 300, shear_mpa: 170}
    core: {shear_xz_mpa: 1.2, shear_yz_mpa: 0.4}
"""
POINTS = {"inside": (0.3, 0.2), "middle": (0.4, 0.3)}


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    """Maps of the response and of the indices, and the indices at the points."""
    root = tmp_path_factory.mktemp("core")
    study = root / "core.yaml"
    study.write_text(STUDY)
    # without steps, which the fewer lines of maps would miss
    (root / "flat.csv").write_text("frequency_hz,psd_pa2_hz\n50,500\n800,500\n")
    folders = panel, sound, response, severity = [
        root / name for name in ("panel", "sound", "response", "severity")
    ]
    for folder in folders:
        folder.mkdir()
    make_panel(study, panel)
    make_sound(study, sound, modes=panel / "modes.nc")
    upstream = {"modes": panel / "modes.nc", "modal_force": sound / "modal_force.nc"}
    upstream["plate"] = panel / "plate.nc"
    made = within(response, RESPONSE)
    call("response", study, upstream | {"section": panel / "section.csv"}, made)
    maps = within(response, {"maps": "maps.nc", "folder": "maps"})
    call("maps", study, upstream | {name: made[name] for name in ("left_out", "psd")}, maps)
    tables = ("oscillators", "peaks", "fatigue", "strength")
    written = within(severity, {name: f"{name}.csv" for name in tables} | {"maps": "maps.nc"})
    read = {name: made[name] for name in ("psd", "summary", "stress", "stress_table")}
    call("severity", study, {**read, "maps": maps["maps"]}, written)
    stresses, indices = (
        xr.load_dataset(folder / "maps.nc", engine="scipy") for folder in (response, severity)
    )
    return stresses, indices, pd.read_csv(severity / "strength.csv")


def test_the_index_of_the_core_is_that_of_its_weaker_direction_at_three_sigma(results):
    stresses, indices, _ = results
    ratio = [
        3e-6 * stresses[f"core_shear_{plane}_rms"] / strength
        for plane, strength in (("xz", 1.2), ("yz", 0.4))
    ]
    expected = np.maximum(*(values.to_numpy() for values in ratio))
    assert expected.max() > 0
    np.testing.assert_allclose(indices["core_index"], expected, rtol=1e-12)


def test_maps_of_a_core_agree_with_its_indices_at_the_points(results):
    # maps are computed on fewer lines, within 1e-3
    _, indices, strength = results
    for point, place in POINTS.items():
        away = np.abs(indices["vertex_position"] - place).sum("axis").to_numpy()
        assert away.min() < 1e-9
        (row,) = strength[(strength["point"] == point) & (strength["layer"] == "core")].itertuples()
        value = float(indices["core_index"].isel(case=0, vertex=int(away.argmin())))
        assert value == pytest.approx(row.maximum_stress_index, rel=2e-3)
