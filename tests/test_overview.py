"""What is printed before a run is what the stages find afterwards."""

import math
import re
from pathlib import Path

import numpy as np
import pytest
import yaml

from pidpanel import Model
from pidpanel.check import checked_study
from pidpanel.cli.study_overview import overview, solve
from pidpanel.coupled.from_study import check_modes, estimated_cpu_seconds
from pidpanel.coupon.from_study import distinct_cases
from pidpanel.panel.from_study import StudiedPanel
from pidpanel.panel.modes import normal_modes
from pidpanel.report.templates import environment
from pidpanel.study import StudyError
from pidpanel.study.panel import Panel

STUDIES = Path(__file__).parents[1] / "workflow" / "studies"


def lines_of(study, tmp_path):
    found = {}
    for line in overview(checked_study(study), tmp_path).split("\n")[1:]:
        what, message = line.split(maxsplit=1)
        found.setdefault(what, []).append(message)
    return found


def test_the_paper_s_panel_is_summed_up_before_it_is_run(tmp_path):
    found = lines_of(STUDIES / "paper.yaml", tmp_path)
    assert found["panel"] == ["1.5 m², 6 kg"]
    assert found["mesh"] == ["600 elements, 651 nodes, about 2400 coordinates"]
    # Navier's
    assert found["modes"] == ["64.9, 124.8, 199.7, 224.7, 259.6, 359.5 Hz on the study's mesh"]
    assert found["points"] == ["326 on PID-1; 189 on PID-2; 318 on PID-3"]
    # 0.04 m² × 0.458 × 1190 kg/m³ × 25 mm × r
    assert found["dampers"] == [
        "PID-1 acrylic, atlas, r = 0.1 to 0.9: about 0.055 to 0.49 kg (0.91 to 8.2 % of the panel)",
        "PID-2 acrylic, atlas, r = 0.5: about 0.27 kg (4.5 % of the panel)",
        "PID-3 acrylic, atlas, r = 0.5: about 0.27 kg (4.5 % of the panel)",
    ]
    assert found["sound"][0].startswith(
        "OASPL 162.0 dB, 161.9 dB in 30 to 2000 Hz; as tabulated 26 third octaves"
    )
    assert found["sound"][0].endswith("; scenarios at 142, 152 dB")
    assert found["time"][0].startswith("85 of 85 coupon cases ")
    assert found["time"][0].endswith(" of CPU time in LIGGGHTS")


def test_the_surroundings_are_named_and_what_others_change(tmp_path):
    # the paper's panel free and in a baffle: each is the other of the other
    changes = {}
    for name in ("launch", "paper"):
        _, setting, change = lines_of(STUDIES / f"{name}.yaml", tmp_path)["sound"]
        words, modes, decibels = re.fullmatch(
            r"other surroundings \((.*)\) change the rms of the modes at (.*) Hz by (.*) dB", change
        ).groups()
        assert modes == "64.9, 125 and 200"
        numbers = re.findall(r"[+−][\d.]+", decibels)
        changes[setting] = words, np.array([float(n.replace("−", "-")) for n in numbers])
    free = "free in the room, both faces, air included; level of the room"
    baffle = "in a baffle, one face, no air; level on the surface"
    assert changes[free][0] == baffle and changes[baffle][0] == free
    assert changes[free][1] == pytest.approx(-changes[baffle][1], abs=0.051)
    # two prototypes: the load of (1, 1) is 5.4 to 6 dB less than on one face; damping and mass of
    # the air lower its rms further
    assert np.all(changes[free][1] > 0) and 6 < changes[free][1][0] < 12


def test_cases_that_are_there_take_no_time(tmp_path):
    study = checked_study(STUDIES / "coupon_friction.yaml")
    cases = list(distinct_cases(study).values())
    for count, expected in ((1, "11 of 12 coupon cases"), (len(cases), "")):
        for case in cases[:count]:
            path = case.outcome_file(tmp_path / "coupon")
            path.parent.mkdir(parents=True, exist_ok=True)
            path.touch()
        _, *times = overview(study, tmp_path).split("\n")
        assert all(expected in line for line in times) and bool(times) == bool(expected)


def test_coupled_runs_are_counted_and_their_time_is_told(tmp_path):
    study = checked_study(STUDIES / "layouts.yaml")
    head, *_, time = overview(study, tmp_path).split("\n")
    assert head.endswith("; panel and particles together in 4")
    *stage, number, unit = time.removeprefix("  time").partition(" or more")[0].split()
    assert stage == ["coupled", "runs"]
    of_unit = {"s": 1, "min": 60, "h": 3600}[unit]
    seconds = estimated_cpu_seconds(study)
    assert float(number) * of_unit == pytest.approx(seconds, abs=0.51 * of_unit)


def test_supports_at_single_points_of_a_sandwich_are_named(tmp_path):
    study = checked_study(STUDIES / "bdf_panel.yaml")
    message = (
        "H1, H2, H3, H4 at single points, where frequencies depend on the mesh; state radius_m, "
        "of a mass from_m and to_m"
    )
    assert f"  supports {message}" in overview(study, tmp_path).split("\n")
    limits = environment().get_template("limits.html").module
    at_points = {"names": study.panel.single_points, "shift": 0.014, "rms": 0.002}
    sentence = " ".join(limits.supports(at_points).split())
    assert "masses at single points (H1, H2, H3, H4): frequencies depend" in sentence
    assert (
        "lowers resonances by up to 1.4 %" in sentence
        and "accelerations by up to 0.2 %" in sentence
    )
    thin = study.panel.section.model_copy(update={"kind": "thin"})
    panel = study.panel.model_copy(update={"section": thin})
    assert not panel.single_points
    corner = panel.support_input.points["H1"]
    locked = corner.model_copy(update={"kind": "hold_down"})
    foot = locked.model_copy(update={"radius_m": 0.01})
    supports = panel.support_input.model_copy(
        update={"points": {"H1": locked, "H2": corner, "H3": foot}}
    )
    assert panel.model_copy(update={"supports": supports}).single_points == ("H1",)
    with_feet = checked_study(STUDIES / "wing.yaml")
    assert with_feet.panel.support_input.points
    assert with_feet.panel.single_points == ("connector",)
    line = with_feet.panel.masses["connector"].model_copy(
        update={"at_m": None, "from_m": (1.0, 0.1), "to_m": (1.1, 0.1)}
    )
    assert not with_feet.panel.model_copy(update={"masses": {"connector": line}}).single_points


def test_masses_holes_and_tables_count(tmp_path):
    values = yaml.safe_load((STUDIES / "sandwich_hole_hinge.yaml").read_text())
    del values["sound"]  # no table of free edges
    values["base"] = {"random": {"spectrum": "gevs_qualification.csv"}}
    study = tmp_path / "hole.yaml"
    study.write_text(yaml.safe_dump(values))
    found = lines_of(study, tmp_path)
    area = 1.5 * 1.0 - math.pi * 0.12**2
    # corners rounded by 8 cm
    area -= (4 - math.pi) * 0.08**2
    assert float(found["panel"][0].split()[0]) == pytest.approx(area, rel=2e-3)
    assert found["panel"][0].endswith("plus 0.5 kg attached")
    # the paper's law weighs nothing that is known
    assert "dampers" not in found


def test_levels_within_the_range_are_those_of_the_bands_in_it(tmp_path, write_study, law_values):
    values = law_values()
    values["response"] = {"frequency_hz": [89.125, 112.202]}  # the band of 100 Hz alone
    values["sound"] = {"spectrum": "smc_s_016_2014_min_third.csv"}
    values["scenarios"] = {}
    found = lines_of(write_study(tmp_path, "one", values), tmp_path)
    level = next(
        float(line.split(",")[1])
        for line in (STUDIES.parent / "data/spl/smc_s_016_2014_min_third.csv").read_text().split()
        if line.startswith("100,")
    )
    assert f", {level:.1f} dB in 89.125 to 112.202 Hz" in found["sound"][0]


def free_plate(**keys):
    section = {"mass_per_area_kg_m2": 4, "bending_stiffness_n_m": 3273}
    panel = {"outline_m": [1.5, 1.0], "section": section, "points": {"A": [0.75, 0.5]}}
    return Panel.model_validate({**panel, **keys})


def test_rigid_bodies_are_counted_and_not_told_as_frequencies(tmp_path):
    solved = solve(free_plate(supports="free", mesh={"elements": [6, 4]}))
    assert solved.rigid == 3
    studied = StudiedPanel(free_plate(supports="free", mesh={"elements": [6, 4]}))
    exact = normal_modes(studied.plate(studied.mesh(tmp_path / "m.msh")), 1000.0)[0]
    np.testing.assert_allclose(solved.frequency, exact[3:9], rtol=1e-6)


def test_a_large_mesh_is_solved_on_a_coarser_one_that_is_near(monkeypatch):
    panel = free_plate(mesh={"kind": "triangles", "size_m": 0.14})
    own = solve(panel)
    assert own.elements == len(own.mesh.cells)
    monkeypatch.setattr("pidpanel.cli.study_overview.MOST_CELLS", {"thin triangles": 150})
    coarse = solve(panel)
    assert coarse.elements < 0.6 * own.elements
    assert len(coarse.mesh.cells) == own.elements
    np.testing.assert_allclose(coarse.frequency, own.frequency, rtol=2e-3)
    assert coarse.coordinates == pytest.approx(own.coordinates, rel=0.15)


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("panel.damping_ratio", 0.3, "panel.damping_ratio = 0.3 is 30 %; bare panels have 0.001 to 0.1, and 0.3 % would be 0.003"),
        ("dampers.paper.equivalent_damping_n_s_m3", 0.03, "dampers.paper.equivalent_damping_n_s_m3 = 0.03 does nothing; it is per area"),
    ],
)  # fmt: skip
def test_an_allowed_value_that_was_most_likely_meant_otherwise_is_named(
    tmp_path, key, value, message
):
    scenarios = {"one": {"patch": "PID-1", "damper": "paper"}}
    model = Model("smoke.yaml").changed(
        {"dampers": {"paper": {"equivalent_damping_n_s_m3": 0}}, "scenarios": scenarios}
    )
    assert "unusual" not in overview(model.study, tmp_path)
    (line,) = (
        t
        for t in overview(model.changed({key: value}).study, tmp_path).split("\n")
        if "unusual" in t
    )
    assert line.startswith(f"  unusual  {message}")


def test_motions_and_limits_far_below_those_of_tests_are_named(tmp_path):
    study = tmp_path / "stiff.yaml"
    text = STIFF.replace("model: coupled", "model: atlas") + "limits: {middle: {psd: limit.csv}}\n"
    for size, named in ((1e-30, 3), (0.1, 0)):
        motions = f"{{random: {{spectrum: limit.csv}}, sine: {{frequency_hz: [60, 90], acceleration_g: {size}}}}}"
        study.write_text(f"{text}base: {motions}\n")
        rows = f"frequency_hz,acceleration_psd_g2_hz\n50,{size}\n290,{size}\n"
        (tmp_path / "limit.csv").write_text(rows)
        assert len(lines_of(study, tmp_path).get("unusual", [])) == named


def test_limits_of_a_part_of_the_response_are_named(tmp_path):
    study = tmp_path / "stiff.yaml"
    text = STIFF.replace("model: coupled", "model: atlas") + "limits: {middle: {psd: limit.csv}}\n"
    study.write_text(text)
    for last, named in ((100, True), (290, False)):
        rows = f"frequency_hz,acceleration_psd_g2_hz\n50,1\n{last},1\n"
        (tmp_path / "limit.csv").write_text(rows)
        lines = " ".join(lines_of(study, tmp_path).get("data", []))
        assert ("limits.middle.psd has 50 to 100 Hz" in lines) == named


STIFF = """
dampers:
  bed:
    cell: {shape: hexagon, across_flats_mm: 6.35, depth_mm: 20, count: 3}
    particles: {diameter_mm: 2, density_kg_m3: 1190, youngs_modulus_mpa: 3200, poissons_ratio: 0.35,
                restitution: 0.8, friction: 0.3}
    model: coupled
panel:
  outline_m: [0.3, 0.2]
  section: {mass_per_area_kg_m2: 4.0, bending_stiffness_n_m: 3273.07}
  mesh: {elements: [12, 8]}
  patches: {A: {centre_m: [0.15, 0.1], size_m: [0.1, 0.1]}}
  points: {middle: [0.15, 0.1]}
scenarios: {s: {patch: A, fill_fraction: 0.5}}
sound: {spectrum: smc_s_016_2014_min_third.csv}
response: {frequency_hz: [50, 300]}
"""


def test_coupled_runs_of_a_panel_without_modes_are_refused_before_they_run(tmp_path):
    # its first mode is at 1623 Hz (Navier); runs ended with −15 % of the energy missing
    study = tmp_path / "stiff.yaml"
    study.write_text(STIFF)
    with pytest.raises(StudyError, match=r"^stiff: .*the first is at 1623 Hz$"):
        overview(checked_study(study), tmp_path)
    check_modes(checked_study(study), 299.0)
    with pytest.raises(StudyError, match="300 Hz"):
        check_modes(checked_study(study), 301.0)
    study.write_text(STIFF.replace("model: coupled", "model: atlas"))
    assert "1623" in " ".join(lines_of(study, tmp_path)["modes"])
