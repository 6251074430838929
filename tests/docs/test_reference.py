"""Pages and the schema that are made from the code are those that are checked in."""

import re

import numpy as np
import pytest
import yaml
from reference_pages import FILES, PAGES, study_page, unit_of

from pidpanel.coupon.cycles import dissipated_energy, first_harmonic
from pidpanel.coupon.liggghts.output import CYCLES_HEADER
from pidpanel.study.json_schema import study_schema


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_what_is_made_is_what_is_checked_in(path):
    assert path.read_text(encoding="utf-8") == PAGES[path](), "run `make reference`"


def test_every_key_stands_on_the_page_with_type_default_and_meaning():
    schema = study_schema()
    page = study_page()
    rows = re.findall(r"^\| `(\w+)` \| (.*) \| (.*) \| (.*) \|$", page, re.MULTILINE)
    wanted = sorted(
        key for model in (schema, *schema["$defs"].values()) for key in model["properties"]
    )
    assert sorted(row[0] for row in rows) == wanted
    for key, kind, default, meaning in rows:
        assert kind and default and len(meaning) > 5, key


def test_units_come_from_names():
    names = {
        "equivalent_damping_n_s_m3": "N\N{NO-BREAK SPACE}s/m³",
        "stiffness_n_m": "N/m",
        "bending_stiffness_n_m": "N m",
        "mass_kg": "kg",
        "max_velocity_m_s": "m/s",
        "acceleration_psd_g2_hz_<point>": "g²/Hz",
        "displacement_psd_mm2_hz_<point>": "mm²/Hz",
        "bare_g_rms": "g",
        "min_cycles": "",
        "samples_per_cycle": "",
        "loss_factor": "",
    }
    assert {name: unit_of(name) for name in names} == names


def test_the_raw_cycles_of_a_coupon_are_described_with_e_d_in_si():
    entries = yaml.safe_load(FILES.read_text(encoding="utf-8"))
    (entry,) = [entry for entry in entries if entry["file"].endswith("cycles_<n>.txt")]
    assert list(entry["variables"]) == CYCLES_HEADER[1].removeprefix("# ").split()
    assert "E_d = 2π ω W v_p_sin/A_c in J/m²" in entry["of"]
    drive, p_sin = {"amplitude": 1e-4, "frequency": 200.0}, np.array([3e-7])
    damping, _ = first_harmonic(p_sin, p_sin, mass=1e-3, area=1e-4, **drive)
    energy = 2 * np.pi * (2 * np.pi * 200.0) * 1e-4 * p_sin / 1e-4
    assert dissipated_energy(damping, **drive) == pytest.approx(energy)
