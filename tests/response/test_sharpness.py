"""Resonances that a mass without damping sharpens: their damping ratio, lines that resolve them."""

import numpy as np
import pytest
import xarray as xr

from pidpanel.panel.files import read_basis
from pidpanel.response import refinement
from pidpanel.response.from_study import write_response
from pidpanel.solve.basis_error import LINES, check_basis
from pidpanel.solve.lines import line_count
from pidpanel.solve.model import ModalBasis
from pidpanel.solve.sharpness import flanks, least_damping_ratio, loaded_modes
from pidpanel.sound.from_study import write_sound
from pidpanel.structure.from_study import write_panel
from pidpanel.study import load_study
from tests.jobs import PANEL, RESPONSE, SOUND, files, within

STUDY = """
panel:
  outline_m: [1.0, 0.8]
  section: {kind: thin, mass_per_area_kg_m2: 4, bending_stiffness_n_m: 3273.07}
  damping_ratio: 0.01
  mesh: {kind: quadrilaterals, elements: [10, 8]}
  patches: {A: {centre_m: [0.5, 0.4], size_m: [1.0, 0.8]}}
  points: {p: [0.5, 0.4]}
sound: {spectrum: smc_s_016_2014_min_third.csv}
response: {frequency_hz: [30, 120]}
dampers: {d: {equivalent_damping_n_s_m3: 0, apparent_mass_kg_m2: MASS}}
scenarios: {s: {layout: {A: {damper: d}}}}
"""


@pytest.mark.parametrize("mass", [0.0, 12.0, 96.0])
def test_mass_all_over_sharpens_every_resonance_alike(mass):
    modal = ModalBasis([30.0, 55.0, 90.0], [0.5, 2.0, 1.0], 0.01)
    whole = np.diag([0.5, 2.0, 1.0])[None] / 4.0  # m″ = 4 kg/m²
    found = least_damping_ratio(modal, whole, np.array([mass]), (1.0, 100.0))
    np.testing.assert_allclose(found, 0.01 / np.sqrt(1 + mass / 4), rtol=1e-12)


def test_a_shape_out_of_range_does_not_count():
    modal = ModalBasis([30.0, 55.0], [1.0, 1.0], 0.01)
    second = np.diag([0.0, 1.0])[None]
    found = [
        least_damping_ratio(modal, second, np.array([3.0]), extent)
        for extent in ((20.0, 40.0), (20.0, 27.0))
    ]
    np.testing.assert_allclose(found, [0.005, 0.01])  # the second has come down to 27.5 Hz


def test_a_peak_shows_beside_a_point_that_moves_much_more():
    f = np.linspace(50.0, 200.0, 101)
    much, little = 1e6 * np.linspace(1e-9, 1.0, 101), np.ones(101)
    little[60] = 2.0
    found = flanks(f, [np.stack([much, little], axis=1)], 1e-3, 9)
    np.testing.assert_allclose(found, [200.0 * 0.999, f[60] * 1.001])


def test_a_slow_mode_has_a_damping_ratio_and_a_rigid_one_none():
    modes = loaded_modes(
        ModalBasis([0.0, 0.05], [1.0, 1.0], 0.01), np.zeros((0, 2, 2)), np.zeros(0), 4.0
    )
    np.testing.assert_allclose(modes.frequency, [0.0, 0.05], atol=1e-12)
    np.testing.assert_allclose(modes.damping_ratio, [np.inf, 0.01])


@pytest.mark.parametrize(("mass", "ratio"), [(3.0, 0.01), (96.0, 0.004)])
def test_the_lines_resolve_what_the_mass_of_a_damper_sharpens(mass, ratio, tmp_path, monkeypatch):
    # ζ/√25 = 0.2 % at 4 lines to a bandwidth as 0.4 % at 8
    tried = []

    def spied(*values):
        tried.append(values[6])
        return check_basis(*values)

    monkeypatch.setattr(refinement, "check_basis", spied)
    (tmp_path / "s.yaml").write_text(STUDY.replace("MASS", str(mass)))
    study = load_study(tmp_path / "s.yaml")
    panel = files(within(tmp_path, PANEL))
    write_panel(study, panel)
    write_sound(study, read_basis(panel.modes), files(within(tmp_path, SOUND)))
    output = files(within(tmp_path, RESPONSE))
    write_response(study, files(within(tmp_path, PANEL | SOUND)), output, None, None)
    with xr.open_dataset(output.psd, engine="scipy") as psd:
        lines, resolved = psd.sizes["frequency"], psd.attrs["resolved_damping_ratio"]
    assert all((len(one) > LINES[1]) == (ratio < refinement.SHARP) for one in tried)
    assert resolved == pytest.approx(ratio, rel=1e-3)
    assert 0 <= lines - line_count(30.0, 120.0, ratio) < 40  # modes and edges of bands
