"""The stated error of the mesh against the same panel on a mesh of half the size."""

from types import SimpleNamespace

import numpy as np
import pytest

import pidpanel
from pidpanel.damping_ratio import DampingRatio
from pidpanel.response import refinement
from pidpanel.response.cases import resolve
from pidpanel.response.refinement import mesh_shifts
from pidpanel.solve.mesh_error import decibels
from pidpanel.solve.model import ModalBasis, ResponseError


def model(elements, size, mass, highest, ratio, patch, step=1):
    a, b = np.array(elements) * size
    return pidpanel.Model({
        "panel": {
            "outline_m": [float(a), float(b)], "damping_ratio": ratio,
            "section": {"kind": "thin", "mass_per_area_kg_m2": 4.0, "bending_stiffness_n_m": 3273.07},
            "mesh": {"kind": "quadrilaterals", "elements": list(elements)},
            "patches": {"p": {"centre_m": [round((patch[0] + patch[2]) / 2 * size, 6),
                                           round((patch[1] + patch[3]) / 2 * size, 6)],
                              "size_m": [round((patch[2] - patch[0]) * size, 6),
                                         round((patch[3] - patch[1]) * size, 6)]}},
            "points": {"A": [4 * step * size, 4 * step * size],
                       "B": [2 * step * size, 3 * step * size]},
        },
        "sound": {"spectrum": "smc_s_016_2014_min_third.csv"},
        "response": {"frequency_hz": [30, highest]},
        "dampers": {"d": {"equivalent_damping_n_s_m3": 0, "apparent_mass_kg_m2": mass}},
        "scenarios": {"s": {"layout": {"p": {"damper": "d"}}}},
    })  # fmt: skip


RECTANGLES = [
    # elements, size, kg/m², Hz, ζ, patch in elements
    ((12, 11), 0.063, 10.0, 600, 0.003, (3, 2, 8, 6)),
    ((12, 12), 0.06, 150.0, 400, 0.02, (5, 5, 7, 7)),
]


SECTIONS = {
    "thin": {"mass_per_area_kg_m2": 4.0, "bending_stiffness_n_m": 3273.07},
    "sandwich": {
        "kind": "sandwich",
        "materials": {"al": {"youngs_modulus_gpa": 70, "poissons_ratio": 0.33,
                             "density_kg_m3": 2700}},
        "faces": [{"material": "al", "thickness_mm": 0.3}],
        "core": {"grade": "3/16-5056-0.0007", "thickness_mm": 15},
        "extra_mass_per_area_kg_m2": 1.0,
    },
}  # fmt: skip


def triangles(section, outline, size, highest, support, ratio, centre, patch, damping, mass):
    a, b = outline
    return pidpanel.Model({
        "panel": {
            "outline_m": [a, b], "damping_ratio": ratio, "section": SECTIONS[section],
            "supports": support, "mesh": {"kind": "triangles", "size_m": size},
            "patches": {"p": {"centre_m": centre, "size_m": patch}},
            "points": {"A": [round(0.31 * a, 4), round(0.27 * b, 4)], "B": centre},
        },
        "sound": {"spectrum": "smc_s_016_2014_min_third.csv"},
        "response": {"frequency_hz": [30, highest]},
        "dampers": {"d": {"equivalent_damping_n_s_m3": damping, "apparent_mass_kg_m2": mass}},
        "scenarios": {"s": {"layout": {"p": {"damper": "d"}}}},
    })  # fmt: skip


TRIANGLES = [
    # section, outline, size and its half, to, support, ζ, patch, N s/m³, kg/m²
    (("sandwich", [0.901, 0.758]), (0.178, 0.089), (316, "clamped", 0.0185),
     ([0.502, 0.33], [0.589, 0.559], 2000, 0.64)),
    (("sandwich", [0.588, 0.535]), (0.08078, 0.0404), (273, "simply_supported", 0.0131),
     ([0.368, 0.256], [0.178, 0.301], 0, 67.57)),
]  # fmt: skip


def of_rectangles(elements, size, mass, highest, ratio, patch):
    """A panel and the same with elements of half the size."""
    double = [2 * n for n in elements], size / 2, mass, highest, ratio, [2 * n for n in patch], 2
    return model(elements, size, mass, highest, ratio, patch), model(*double)


def of_triangles(panel, sizes, response, damper):
    return [triangles(*panel, size, *response, *damper) for size in sizes]


PANELS = [(of_rectangles, case) for case in RECTANGLES] + [(of_triangles, c) for c in TRIANGLES]


@pytest.mark.parametrize(("made", "case"), PANELS)
def test_the_stated_error_of_the_mesh_contains_that_of_dampers_light_and_heavy(made, case):
    coarse, fine = made(*case)
    found, true = coarse.response(), fine.response()
    f, fine_f = found["frequency"].to_numpy(), true["frequency"].to_numpy()
    stated = coarse.summary().query("scenario == 's'").set_index("point")
    for point in ("A", "B"):
        one = {"scenario": "s", "point": point}
        psd, exact = (
            psds["acceleration_psd"].sel(one).squeeze().to_numpy() for psds in (found, true)
        )
        smooth = np.exp(np.interp(np.log(f), np.log(fine_f), np.log(exact)))
        # each band of the sound begins with a pair of lines
        pair = np.diff(np.log(f), prepend=0.0) < 1e-12
        error = np.max(np.abs(psd / smooth - 1)[np.convolve(pair, np.ones(9), "same") == 0])
        rms = [np.sqrt(np.trapezoid(s, x)) for s, x in ((psd, f), (exact, fine_f))]
        assert error <= stated["mesh_error"][point] + stated["basis_error"][point]
        assert abs(rms[0] / rms[1] - 1) <= stated["mesh_error_rms"][point] + 1e-3
        assert abs(rms[0] / rms[1] - 1) < 5e-3
        assert error < 10**0.05 - 1


def test_a_patch_has_the_error_of_its_own_elements():
    damper = ([0.45, 0.2], [0.1, 0.12], 300, 60)
    panel = ("sandwich", [0.7, 0.5], 0.0977, 500, "simply_supported", 0.01)
    stated = triangles(*panel, *damper).summary().query("scenario == 's'")
    assert decibels(stated["mesh_error"].max()) < 0.4
    assert not stated["doubts"].str.contains("mesh too coarse").any()


HEAVY = ("sandwich", [0.5, 0.4], 0.05, 1000, "simply_supported", 0.01, [0.25, 0.2], [0.12, 0.1],
         100, 90)  # fmt: skip


def test_elements_made_for_a_damper_do_where_it_weighs_thirty_times_the_panel():
    rows = triangles(*HEAVY).summary().query("scenario == 's'")
    assert 0.05 < decibels(rows["mesh_error"].max()) < 0.5


def test_a_scenario_has_the_mesh_error_of_its_own_dampers():
    both = triangles(*HEAVY).changed({
        "dampers.light": {"equivalent_damping_n_s_m3": 100, "apparent_mass_kg_m2": 5},
        "scenarios.t": {"layout": {"p": {"damper": "light"}}},
    })  # fmt: skip
    alone = both.changed({"scenarios": {"t": {"layout": {"p": {"damper": "light"}}}}})
    errors = both.summary().groupby("scenario")["mesh_error"].max()
    assert errors["t"] < 0.5 * errors["s"]
    single = alone.summary().groupby("scenario")["mesh_error"].max()
    # alone it has longer elements on the patch
    assert 0.3 * single["t"] < errors["t"] < 1.1 * single["t"]


@pytest.mark.parametrize(
    ("elements", "size", "mass", "highest"),
    [((6, 4), 0.25, 30.0, 300), ((12, 8), 0.125, 150.0, 1200)],
)
def test_a_mesh_that_heavy_dampers_make_too_coarse_is_refused(elements, size, mass, highest):
    with pytest.raises(pidpanel.StudyError, match="under p, whose damper can weigh"):
        model(elements, size, mass, highest, 0.01, (0, 0, *elements))


def test_resonances_that_no_lines_resolve_are_refused():
    modal = ModalBasis([100.0, 900.0], [1.0, 1.0], 0.001)
    basis = SimpleNamespace(patch_overlap=np.eye(2)[None] / 4.0)  # of a panel of 4 kg/m²
    settings = SimpleNamespace(frequency_range=(30.0, 2000.0), damping_ratio=DampingRatio((0.001,)))
    panel = SimpleNamespace(modal=modal, basis=basis, settings=settings)
    with pytest.raises(ResponseError, match=r"takes \d+ frequency lines .* panel\.damping_ratio"):
        resolve(panel, np.array([150.0]))


FOIL = {"foil": {"youngs_modulus_gpa": 70, "poissons_ratio": 0.33, "density_kg_m3": 2700}}
FREE = [
    (0.07, {"kind": "sandwich", "materials": FOIL, "faces": [{"material": "foil", "thickness_mm": 0.3}],
            "core": {"shear_modulus_l_mpa": 186, "shear_modulus_w_mpa": 90, "density_kg_m3": 32,
                     "thickness_mm": 10}}),
    (0.08, {"kind": "solid", **FOIL["foil"], "thickness_mm": 12}),
]  # fmt: skip


@pytest.mark.parametrize(("size", "section"), FREE, ids=["sandwich", "solid"])
def test_the_stated_error_of_the_mesh_contains_that_of_the_shear_at_free_edges(
    monkeypatch, size, section
):
    free = pidpanel.Model({
        "panel": {"outline_m": [1.2, 0.36], "supports": "free", "damping_ratio": 0.01,
                  "section": section, "mesh": {"kind": "triangles", "size_m": size},
                  "patches": {"p": {"centre_m": [0.54, 0.18], "diameter_m": 0.072}},
                  "points": {"A": [1.11, 0.32]}},
        "sound": {"spectrum": "smc_s_016_2014_min_third.csv"},
        "response": {"frequency_hz": [36, 400]},
        "dampers": {"d": {"equivalent_damping_n_s_m3": 100}},
        "scenarios": {"s": {"layout": {"p": {"damper": "d"}}}},
    })  # fmt: skip
    coarse, fine = (
        model.modes()["natural_frequency"].to_numpy()
        for model in (free, free.changed({"panel.mesh.size_m": size / 3}))
    )
    of_range = (fine[: len(coarse)] > 1) & (fine[: len(coarse)] < 400)
    true = np.max(coarse[of_range] / fine[: len(coarse)][of_range] - 1)
    shifts = []
    monkeypatch.setattr(
        refinement, "mesh_shifts", lambda *args: shifts.append(mesh_shifts(*args)) or shifts[-1]
    )
    rows = free.summary()
    stated = max(shift.waves.max() for shift in shifts[0].values())
    assert 0.5 * stated < true < stated
    assert rows["doubts"].str.contains("mesh too coarse").all()


def test_rows_of_a_panel_that_single_points_hold_are_not_trusted():
    held = {f"h{x}": {"at_m": [x, 0.3], "kind": "hold_down", "radius_m": 0} for x in (0.2, 0.7)}
    panel = triangles("thin", [0.9, 0.6], 0.12, 200, "free", 0.02, [0.45, 0.3], [0.1, 0.1], 100, 1)
    rows = panel.changed({"panel.supports": {"outline": "free", "points": held}}).summary()
    assert rows["doubts"].str.contains("held at single points").all()
    assert (rows["point_error_rms"] > 0.05).all()
