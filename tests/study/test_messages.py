"""A mistake in a study is one line with file, line, key, value and what is allowed."""

import copy
from pathlib import Path

import pytest
import yaml

from pidpanel.study import StudyError, load_any_study

STUDIES = Path(__file__).parents[2] / "workflow" / "studies"
SMOKE = yaml.safe_load((STUDIES / "smoke.yaml").read_text())
BED = {key: value for key, value in SMOKE["dampers"]["acrylic"].items() if key != "model"}
COUPON_ALONE = {"coupon": BED}
FILL = {"fill": {"patch": "PID-1", "fill_fraction": [0.4, 0.8]}}
PANEL_ALONE = SMOKE | {
    "dampers": {"paper": {"law": "paper_corrected"}}, "scenarios": FILL, "damping": {},
}  # fmt: skip
SMOKE = SMOKE | {"dampers": {"bed": {**BED, "model": "tones"}}, "scenarios": FILL, "damping": {}}
COUPLED = SMOKE | {"dampers": {"bed": BED}, "damping": {"coupled": {"duration_s": 1}}}
SANDWICH = PANEL_ALONE | {
    "panel": yaml.safe_load((STUDIES / "sandwich_hole_hinge.yaml").read_text())["panel"],
    "scenarios": {"fill": {"patch": "centre", "fill_fraction": [0.4]}},
}
FROM_FILE = PANEL_ALONE | {
    "panel": yaml.safe_load((STUDIES / "bdf_panel.yaml").read_text())["panel"],
    "scenarios": {"fill": {"patch": "middle", "fill_fraction": [0.4]}},
}
FROM_FILE["panel"]["mesh"]["file"] = str(STUDIES / "bdf_panel.bdf")
FREE = PANEL_ALONE | {"sound": {"spectrum": "smc_s_016_2014_min_third.csv", "surroundings": "free"}}
L_PANEL = PANEL_ALONE | {
    "panel": yaml.safe_load((STUDIES / "l_panel.yaml").read_text())["panel"],
    "scenarios": {"fill": {"patch": "arm", "fill_fraction": [0.4]}},
}


def changed(values, key, value):
    """The values with one key set, or taken away."""
    values = copy.deepcopy(values)
    *parents, last = key.split(".") if isinstance(key, str) else key
    section = values
    for parent in parents:
        section = section[parent]
    if value is None:
        section.pop(last)
    else:
        section[last] = value
    return values


def told(refusal, study, key, value):
    """The one line of the refusal after file and line, and the way to the key on that line."""
    lines, line = refusal(changed(study, key, value))
    assert len(lines) == 1, lines
    file, number, message = lines[0].split(":", 2)
    assert file == "mine.yaml"
    (way,) = (way for way, at in line.items() if at == int(number))
    return ".".join(map(str, way)), message.removeprefix(" ")


@pytest.mark.parametrize(
    ("key", "value", "message"),
    [
        ("dampers.bed.sweep.fill_fraction", [0.4, 1.4], "dampers.bed.sweep.fill_fraction[1] = 1.4: must be from 0.02 to 1"),
        ("dampers.bed.sweep.fill_fraction", [7], "dampers.bed.sweep.fill_fraction[0] = 7: must be from 0.02 to 1; 7 % would be 0.07"),
        ("dampers.bed.sweep.fill_fraction", [], "dampers.bed.sweep.fill_fraction = []: must have at least 1 value, not 0"),
        ("dampers.bed.sweep.frequency_hz", [100, 100.0], "dampers.bed.sweep.frequency_hz[1] = 100.0: duplicate value; its cases would have the same labels"),
        ("dampers.bed.sweep.frequency_hz", [0.1], "dampers.bed.sweep.frequency_hz[0] = 0.1: must be from 1 to 20000; 0.1 kHz would be 100"),
        ("dampers.bed.sweep.frequency_hz", 5, "dampers.bed.sweep.frequency_hz = 5: must be a mapping with keys from, to, step or a list"),
        ("dampers.bed.cell.shape", "triangle", "dampers.bed.cell.shape = triangle: must be 'hexagon', 'square' or 'circle'"),
        ("dampers.bed.cell.count", 2.5, "dampers.bed.cell.count = 2.5: must be a whole number"),
        ("dampers.bed.cell", "deep", "dampers.bed.cell = deep: must be a mapping with keys shape, across_flats_mm, depth_mm, count"),
        ("dampers.bed.particles.shell_mm", 1.5, "dampers.bed.particles.shell_mm = 1.5: must be below half of diameter_mm = 2.5"),
        ("dampers.bed.particles.diameter_mm", 8, "dampers.bed.particles.diameter_mm = 8: the largest particle, 8 mm, must be at most 0.9 of the cell's across_flats_mm = 6.35 and depth_mm = 10"),
        ("dampers.bed.sweep.diameter_mm", [2, 8], "dampers.bed.sweep.diameter_mm[1] = 8: the largest particle, 8 mm, must be at most 0.9 of the cell's across_flats_mm = 6.35 and depth_mm = 10"),
        ("dampers.bed.gravity_direction", [0, 0, 0], "dampers.bed.gravity_direction = [0, 0, 0]: must not be zero; for no gravity set gravity_g: 0"),
        ("dampers.bed.sweep.displacement_mm", [0.1], "dampers.bed.sweep.displacement_mm = [0.1]: not allowed together with acceleration_g"),
        ("dampers.bed.accuracy.max_cycles", 8, "dampers.bed.accuracy.max_cycles = 8: must be at least min_cycles = 10"),
        ("panel.damping_ratio", "much", "panel.damping_ratio = much: must be a number or a list or a CSV file"),
        ("panel.supports", "glued", "panel.supports = glued: must be 'simply_supported', 'simply_supported_soft', 'clamped', 'free' or a mapping with keys outline, holes, edges, points"),
        ("panel.in_plane_edges", "fixed", "panel.in_plane_edges = fixed: must be 'free' or 'held'"),
        ("panel.section.extensional_stiffness_n_m", 2.0e7, "panel.section.extensional_stiffness_n_m = 20000000.0: must be at least 2.095e+07, 4 D/t² of two faces as far apart as the panel is thick"),
        ("panel.outline_m", [1.5, -1], "panel.outline_m[1] = -1: must be from 0.01 to 30"),
        ("panel.outline_m", [[0, 0], [1, 0]], "panel.outline_m = [[0, 0], [1, 0]]: must have at least 3 values, not 2"),
        ("panel.points.centre", [0.7, 0.5, 0.1], "panel.points.centre = [0.7, 0.5, 0.1]: must have at most 2 values, not 3"),
        ("panel.points.centre", [2.0, 0.5], "panel.points.centre = [2.0, 0.5]: must lie on the panel, x 0…1.5 m, y 0…1 m"),
        ("sound.oaspl_db", float("nan"), "sound.oaspl_db = NaN: must be a finite number"),
        ("sound.shift_db", 3, "sound.shift_db = 3: not allowed together with oaspl_db = 150"),
        ("sound.incidence_deg", -10, "sound.incidence_deg = -10: must be from 0 to 90"),
        ("sound.incidence_deg", 10, "sound.incidence_deg = 10: required for field: plane_wave, not allowed otherwise"),
        ("sound.azimuth_deg", 45, "sound.azimuth_deg = 45: only allowed for field: plane_wave or progressive_wave"),
        ("sound.loaded_sides", 3, "sound.loaded_sides = 3: must be 1 or 2"),
        ("response.damper_mass", "perhaps", "response.damper_mass = perhaps: must be true or false"),
        ("response.radiation", "both", "response.radiation = both: must be 'none', 'one_side' or 'two_sides'"),
        ("response.maps", ["PID-1"], "response.maps[0] = PID-1: must be one of bare_150dB, PID-1_r0.4_150dB, PID-1_r0.8_150dB"),
        ("response.frequency_hz", [400, 100], "response.frequency_hz = [400, 100]: must be two values, the second above the first"),
        ("scenarios.fill.patch", "PID-9", "scenarios.fill.patch = PID-9: must be one of panel.patches: PID-1"),
        ("scenarios.fill.fill_fraction", [0.4, 0.95], "scenarios.fill.fill_fraction[1] = 0.95: must be in the range of dampers.bed.sweep, 0.4 to 0.8"),
        ("title", [3], "title = [3]: must be text"),
        ("name", "a/b", "name = a/b: must be up to 80 letters a to z or A to Z, digits, '_' and '-', the first a letter or a digit"),
        ("name", "a" * 81, f"name = {'a' * 60}…: must be up to 80 letters a to z or A to Z, digits, '_' and '-', the first a letter or a digit"),
        ("scenarios", {f"s{i}": {"patch": "PID-1", "fill_fraction": 0.4} for i in range(1001)}, "scenarios = {s0: {patch: PID-1, fill_fraction: 0.4}, s1: {patch: PID-1, …: has 1001 names; allowed are 1000"),
        ("dampers", {f"d{i}": {"law": "paper_corrected"} for i in range(1001)}, "dampers = {d0: {law: paper_corrected}, d1: {law: paper_corrected}, d2:…: has 1001 names; allowed are 1000"),
        ("dampers.bed.cell.dept_mm", 3, "dampers.bed.cell.dept_mm = 3: unknown key; did you mean depth_mm?"),
        ("pannel", 3, "pannel = 3: unknown key; did you mean panel?"),
        ("sound.colour", "a\tb", "sound.colour = a\\tb: unknown key; allowed are spectrum, oaspl_db, shift_db, field, incidence_deg, azimuth_deg, surroundings, loaded_sides, pressure_reference, speed_m_s, air_density_kg_m3"),
    ],
)  # fmt: skip
def test_a_wrong_value_is_told_at_its_own_line(refusal, key, value, message):
    assert told(refusal, SMOKE, key, value) == (key, message)


@pytest.mark.parametrize(
    ("study", "key", "value", "at", "message"),
    [
        (SMOKE, "panel.section", None, "panel", "panel.section: missing"),
        (SMOKE, "dampers.bed.particles.distribution", {"kind": "normal"}, "dampers.bed.particles.distribution", "dampers.bed.particles.distribution.deviation_mm: missing"),
        (SMOKE, "dampers.bed.particles.distribution", {"deviation_mm": 1}, "dampers.bed.particles.distribution", "dampers.bed.particles.distribution.kind: missing; must be 'mono', 'normal', 'uniform' or 'binary'"),
        (SMOKE, "dampers.bed.particles.distribution", {"kind": "gauss"}, "dampers.bed.particles.distribution.kind", "dampers.bed.particles.distribution.kind = gauss: must be 'mono', 'normal', 'uniform' or 'binary'"),
        (SMOKE, "dampers.bed.particles.distribution", {"kind": "binary", "second_mm": 0.5, "second_share": 0.5}, "dampers.bed.particles.distribution",
         "dampers.bed.particles.distribution = {kind: binary, second_mm: 0.5, second_share: 0.5}: the smallest particle, 0.5 mm, must be at least 0.4 of the largest, 2.5 mm: other mixtures separate by size"),
        (SMOKE, "dampers.bed.particles", {"shell_mm": 0.2, "distribution": {"kind": "uniform", "half_width_mm": 0.1}}, "dampers.bed.particles.shell_mm", "dampers.bed.particles.shell_mm = 0.2: only allowed for distribution: {kind: mono}"),
        (SMOKE, "dampers.bed.sweep.acceleration_g", None, "dampers.bed.sweep", "dampers.bed.sweep.acceleration_g: missing; required unless displacement_mm is given"),
        (SMOKE, "dampers.bed.sweep.frequency_hz", {"from": 5, "to": 1, "step": 1}, "dampers.bed.sweep.frequency_hz.to", "dampers.bed.sweep.frequency_hz.to = 1: must be at least from = 5"),
        (SMOKE, "dampers.bed.sweep.frequency_hz", {"from": 5, "to": 9}, "dampers.bed.sweep.frequency_hz", "dampers.bed.sweep.frequency_hz.step: missing"),
        (SMOKE, "dampers.bed.vary", {"particles.friction": [0.1]}, "dampers.bed.vary", "dampers.bed.vary = {particles.friction: [0.1]}: only in a study of the coupon alone"),
        (SMOKE, "damping.level", {"kind": "stated"}, "damping.level", "damping.level.acceleration_g: required for kind: stated, not allowed otherwise"),
        (PANEL_ALONE, "dampers.paper", {"table": "none.csv"}, "dampers.paper.table", "dampers.paper.table = none.csv: no such file; must be a path relative to the study, or one of acrylic_2mm.csv"),
        (SMOKE, "damping.coupled", {"runs": 3}, "damping.coupled", "damping.coupled = {runs: 3}: only allowed with a damper with model: coupled in a scenario"),
        (SMOKE, "damping.random", {"seeds": 2}, "damping.random", "damping.random = {seeds: 2}: was removed; the keys are those of damping.coupled, with dampers: {acrylic: {cell: …, particles: …, model: coupled}}"),
        (SMOKE, "damping.target", {"relative_error": 0.1}, "damping.target", "damping.target = {relative_error: 0.1}: was removed, because its errors were too small; the whole of the sweep is run"),
        (PANEL_ALONE, "damping.tones", {"batch": 4}, "damping.tones", "damping.tones = {batch: 4}: was removed; use dampers: {acrylic: {cell: …, particles: …, model: coupled}}, or extend the sweep to the motions"),
        (PANEL_ALONE, "response.radiation_beside", "one_side", "response.radiation_beside", "response.radiation_beside = one_side: was removed; run a copy of the study with response.radiation, and pidpanel compare both"),
        (COUPLED, "response.frequency_hz", [100, 104], "damping.coupled.duration_s", "damping.coupled.duration_s = 1: must be at least 2.5 for response.frequency_hz = [100, 104]"),
        (SMOKE, "sound.field", "plane_wave", "sound", "sound.incidence_deg: required for field: plane_wave, not allowed otherwise"),
        (FREE, "sound.pressure_reference", "surface", "sound.pressure_reference", "sound.pressure_reference = surface: must be room with free edges; set sound.surroundings: baffle for it"),
        (FREE, "sound.loaded_sides", 2, "sound.loaded_sides", "sound.loaded_sides = 2: not allowed with free edges; set sound.surroundings: baffle to load one face"),
        (FREE, "sound.field", "uniform", "sound.field", "sound.field = uniform: must be diffuse or plane_wave with free edges; set sound.surroundings: baffle for it"),
        (FREE, "sound.field", "progressive_wave", "sound.field", "sound.field = progressive_wave: must be diffuse or plane_wave with free edges, where a wave along the panel does not load it; set sound.surroundings: baffle for it"),
        (FREE, "sound", FREE["sound"] | {"field": "plane_wave", "incidence_deg": 90}, "sound.incidence_deg", "sound.incidence_deg = 90: must be below 90 with free edges, where a wave along the panel does not load it"),
        (FREE, "response.radiation", "two_sides", "response.radiation", "response.radiation = two_sides: must be none, or omitted for air on both faces, with free edges; set sound.surroundings: baffle for it"),
        (FREE, "response.air_mass", False, "response.air_mass", "response.air_mass = false: must be true with free edges; set sound.surroundings: baffle for resistance alone"),
        (FREE, "response.modal_damping", "diagonal", "response.modal_damping", "response.modal_damping = diagonal: needs response.radiation: none with free edges; the paper's form has no air"),
        (FREE, "sound.surroundings", {"wall_m": 0.002}, "sound.surroundings.wall_m", "sound.surroundings.wall_m = 0.002: must be at least a tenth of the panel's thickness, 0.0025"),
        (FREE, "sound.surroundings", {"wall_m": 80}, "sound.surroundings.wall_m", "sound.surroundings.wall_m = 80: must be from 0.0001 to 2; 80 mm would be 0.08"),
        (FREE, "sound.surroundings", "wall", "sound.surroundings", "sound.surroundings = wall: must be 'free', 'baffle' or a mapping with keys wall_m"),
        (FREE, "sound", {"surroundings": "free"}, "sound", "sound.spectrum: missing"),
        (SMOKE, "response", {"modal_damping": "diagonal", "radiation": "one_side"}, "response.radiation", "response.radiation = one_side: must be none for modal_damping: diagonal, the paper's form"),
        (SMOKE, "scenarios.fill.oaspl_db", [140, 150], "scenarios.fill", "scenarios.fill = {patch: PID-1, fill_fraction: [0.4, 0.8], oaspl_db: [140, 15…: only one of patch, fill_fraction and oaspl_db may be a list, not 2"),
        (SMOKE, "panel.patches", {"PID-1": {"centre_m": [1.45, 0.5], "size_m": [0.3, 0.2]}}, "panel.patches.PID-1",
         "panel.patches.PID-1 = {centre_m: [1.45, 0.5], size_m: [0.3, 0.2]}: must lie on the panel, x 0…1.5 m, y 0…1 m; it covers x 1.3…1.6 m, y 0.4…0.6 m"),
        (SMOKE, "panel.corner_radius_m", 0.1, "panel.mesh.kind", "panel.mesh.kind = quadrilaterals: quadrilaterals do not allow an outline other than a whole rectangle; use mesh: {kind: triangles, size_m: …}"),
        (SMOKE, "panel.mesh", {"kind": "triangles"}, "panel.mesh", "panel.mesh.size_m: missing"),
        (SMOKE, "panel.mesh", {"corner_size_m": 0.1}, "panel.mesh.corner_size_m", "panel.mesh.corner_size_m = 0.1: unknown key; allowed are kind, elements"),
        (SMOKE, "panel.mesh", {"kind": "file"}, "panel.mesh", "panel.mesh.file: missing"),
        (SMOKE, "panel.mesh", {"kind": "file", "file": "a.step"}, "panel.mesh.file", "panel.mesh.file = a.step: must end in one of .bdf, .dat, .nas, .fem, .inp, .blk, .msh"),
        (SMOKE, "panel.mesh", {"kind": "file", "file": "a.bdf"}, "panel.mesh.file", "panel.mesh.file = a.bdf: no such file; must be a path relative to the study"),
        (SMOKE, "panel.outline_m", None, "panel", "panel.outline_m: missing; required unless mesh: {kind: file} is given"),
        (FROM_FILE, "panel.outline_m", [1, 1], "panel.outline_m", "panel.outline_m = [1, 1]: not allowed with mesh: {kind: file}, which has its own"),
        (FROM_FILE, "panel.corner_radius_m", 0.1, "panel.corner_radius_m", "panel.corner_radius_m = 0.1: not allowed with mesh: {kind: file}, which has its own"),
        (SANDWICH, "panel.section.core.grade", "3/16-5056-0.0008", "panel.section.core.grade", "panel.section.core.grade = 3/16-5056-0.0008: unknown grade; the nearest are 3/16-5056-0.0007, 3/16-5056-0.002, 3/16-5056-0.001"),
        (SANDWICH, "panel.section.core", {"thickness_mm": 9}, "panel.section.core", "panel.section.core = {thickness_mm: 9}: must have either grade, or density_kg_m3, shear_modulus_l_mpa and shear_modulus_w_mpa"),
        (SANDWICH, "panel.section.kind", "thick", "panel.section.kind", "panel.section.kind = thick: must be 'thin', 'solid' or 'sandwich'"),
        (SANDWICH, "panel.section", 3, "panel.section", "panel.section = 3: must be a mapping with a key kind"),
        (SANDWICH, "panel.section.facs", [], "panel.section.facs", "panel.section.facs = []: unknown key; did you mean faces?"),
        (SANDWICH, "panel.section.faces", [{"material": "foil", "thickness_mm": 1}], "panel.section.faces", "panel.section.faces[0].material = foil: must be one of materials: tape, Al 2024-T3, Al 6061-T6, Al 7075-T6, T300/5208 carbon, AS/3501 carbon, Kevlar 49/epoxy, Scotchply 1002 glass"),
        (SANDWICH, "panel.section.top", [{"material": "tape", "thickness_mm": 1}], "panel.section", "panel.section = {kind: sandwich, materials: {tape: {e1_gpa: 280, e2_gpa: 6.5…: must have either faces, or top and bottom"),
        (SANDWICH, "panel.section.materials.tape", {"e1_gpa": 1, "density_kg_m3": 9}, "panel.section.materials.tape",
         "panel.section.materials.tape = {e1_gpa: 1, density_kg_m3: 9}: must have either youngs_modulus_gpa and poissons_ratio, or e1_gpa, e2_gpa, g12_gpa and nu12"),
        (SANDWICH, "panel.section.materials.tape.nu12", 7, "panel.section.materials.tape.nu12", "panel.section.materials.tape.nu12 = 7: must be above -2 and below 2; 7 % would be 0.07"),
        (SANDWICH, "panel.supports.points.hinge 1.grid", 7, "panel.supports.points.hinge 1", "panel.supports.points.hinge 1 = {at_m: [0.3, 0.06], kind: hinge, radius_m: 0.02, grid: 7}: must have either at_m, or grid"),
        (SANDWICH, "panel.supports.points.hinge 1", {"at_m": [0.1, 0.1], "kind": "spring", "stiffness_n_m": 1, "radius_m": 0.1}, "panel.supports.points.hinge 1.radius_m", "panel.supports.points.hinge 1.radius_m = 0.1: only allowed for kind: hinge or hold_down"),
        (SANDWICH, "panel.masses.connector.to_m", [1, 1], "panel.masses.connector", "panel.masses.connector = {at_m: [0.75, 0.1], mass_kg: 0.2, to_m: [1, 1]}: must have either at_m, or grid, or from_m and to_m"),
        (SANDWICH, "panel.holes.cut-out.size_m", [0.1, 0.1], "panel.holes.cut-out", "panel.holes.cut-out = {centre_m: [1.05, 0.65], diameter_m: 0.24, size_m: [0.1, 0.1…: must have either centre_m and size_m, or centre_m and diameter_m, or corners_m"),
        (SANDWICH, "panel.holes.cut-out.corner_radius_m", 0.1, "panel.holes.cut-out.corner_radius_m", "panel.holes.cut-out.corner_radius_m = 0.1: only allowed with corners_m"),
        (SANDWICH, "panel.corner_radius_m", 0.6, "panel.corner_radius_m", "panel.corner_radius_m = 0.6: corner radius 0.6 m: the edge from (1.5, 0) m is 1 m long, its two arcs need 1.2 m"),
        (L_PANEL, "panel.outline_m", [[0, 0], [1, 1], [1, 0], [0, 2]], "panel.outline_m", "panel.outline_m = [[0, 0], [1, 1], [1, 0], [0, 2]]: outline crosses itself: the edge from (0, 0) m meets the edge from (1, 0) m"),
        (L_PANEL, "panel.patches.arm.group", "2", "panel.patches.arm", "panel.patches.arm = {centre_m: [1.1, 0.25], size_m: [0.2, 0.2], group: 2}: must have either centre_m and size_m, or centre_m and diameter_m, or corners_m, or group"),
        (L_PANEL, "panel.patches.arm", {"group": 2}, "panel.patches.arm.group", "panel.patches.arm.group = 2: only allowed with mesh: {kind: file}"),
        (L_PANEL, "panel.points.A", {"grid": 3}, "panel.points.A.grid", "panel.points.A.grid = 3: only allowed with mesh: {kind: file}"),
        (COUPON_ALONE, ("coupon", "vary"), {"particles.colour": ["red"]}, "coupon.vary.particles.colour", "coupon.vary.particles.colour = [red]: unknown key; allowed are diameter_mm, distribution, density_kg_m3, shell_mm, youngs_modulus_mpa, poissons_ratio, restitution, friction, rolling_friction"),
        (COUPON_ALONE, ("coupon", "vary"), {"partikles.friction": [1]}, "coupon.vary.partikles.friction", "coupon.vary.partikles.friction = [1]: unknown key; did you mean particles.friction?"),
        (COUPON_ALONE, ("coupon", "vary"), {"sweep.fill_fraction": [0.1]}, "coupon.vary.sweep.fill_fraction", "coupon.vary.sweep.fill_fraction = [0.1]: cannot be varied"),
        (COUPON_ALONE, ("coupon", "vary"), {"particles.friction": [0.1, 7]}, "coupon.vary.particles.friction", "coupon.vary.particles.friction[1] = 7: must be from 0 to 5; 7 % would be 0.07"),
        (COUPON_ALONE, ("coupon", "vary"), {"particles.friction": [0.1, 0.1]}, "coupon.vary.particles.friction", "coupon.vary.particles.friction[1] = 0.1: duplicate value"),
        (COUPON_ALONE, ("coupon", "vary"), {"cell": [{"depth_mm": 9}, {"dept_mm": 9}]}, "coupon.vary.cell", "coupon.vary.cell[1].dept_mm = 9: unknown key; did you mean depth_mm?"),
        (COUPON_ALONE, ("coupon", "vary"), {"cell.depth_mm": [20, 2], "gravity_g": [0, 1]}, "coupon.vary", "coupon.vary = {cell.depth_mm: [20, 2], gravity_g: [0, 1]}: with cell.depth_mm = 2, gravity_g = 0: particles.diameter_mm: the largest particle, 2.5 mm, must be at most 0.9 of the cell's across_flats_mm = 6.35 and depth_mm = 2"),
    ],
)  # fmt: skip
def test_a_mistake_of_several_keys_is_told_at_the_one_to_change(
    refusal, study, key, value, at, message
):
    assert told(refusal, study, key, value) == (at, message)


def test_a_file_that_is_not_there_is_told_with_those_that_are(refusal):
    _, message = told(refusal, SMOKE, "sound.spectrum", "nowhere.csv")
    start = "sound.spectrum = nowhere.csv: no such file; must be a path relative to the study, or one of "
    assert message.startswith(start)
    assert "smc_s_016_2014_min_third.csv" in message
    _, message = told(refusal, SMOKE, "dampers.bed.deck", "mine.in.j2")
    assert message.startswith("dampers.bed.deck = mine.in.j2: no such file")
    assert "shake_lab.in.j2" in message


def test_a_varied_deck_that_is_not_there_is_told(refusal):
    decks = {"deck": ["shake.in.j2", "mine.in.j2"]}
    at, message = told(refusal, COUPON_ALONE, "coupon.vary", decks)
    assert at == "coupon.vary.deck"
    assert message.startswith("coupon.vary.deck[1] = mine.in.j2: no such file")


def test_a_study_of_nothing_is_refused(refusal):
    lines, _ = refusal({"coupon": None})
    assert lines == ["mine.yaml:1: coupon: has no value; give one, or omit the key"]


def test_all_mistakes_of_a_file_are_told_in_the_order_of_its_lines(refusal):
    study = changed(SMOKE, "panel.patches.far", {"centre_m": [3, 3], "size_m": [1, 1]})
    study = changed(study, "panel.patches.low", {"centre_m": [0.5, -3], "size_m": [1, 1]})
    study = changed(study, "panel.points.far", [3, 3])
    study = changed(study, "response.frequency_hz", [9, 3])
    study = changed(study, "dampers.bed.cell.depth", 3)
    lines, line = refusal(study)
    ways = [
        ("dampers", "bed", "cell", "depth"),
        ("panel", "patches", "far"),
        ("panel", "patches", "low"),
        ("panel", "points", "far"),
        ("response", "frequency_hz"),
    ]
    told_at = [int(one.split(":")[1]) for one in lines]
    assert told_at == sorted(line[way] for way in ways)


def test_all_that_sections_require_of_each_other_is_told(refusal):
    study = changed(SMOKE, "scenarios.low", {"patch": "A", "fill_fraction": [0.1, 0.9]})
    study = changed(study, "scenarios.both", {"patch": ["B", "PID-1", "C"], "fill_fraction": 0.5})
    lines, _ = refusal(study)
    assert [one.split(": ")[1] for one in lines] == [
        "scenarios.low.patch = A",
        "scenarios.low.fill_fraction[0] = 0.1",
        "scenarios.low.fill_fraction[1] = 0.9",
        "scenarios.both.patch[0] = B",
        "scenarios.both.patch[2] = C",
    ]


@pytest.mark.parametrize("name", ["a/b", "/", "", '12" core'])
@pytest.mark.parametrize("where", ["panel.patches", "panel.points", "scenarios"])
def test_a_name_that_cannot_be_in_the_name_of_a_file_is_refused(refusal, where, name):
    values = {
        "panel.patches": {"centre_m": [0.7, 0.5], "size_m": [0.1, 0.1]},
        "panel.points": [0.1, 0.1],
        "scenarios": {"patch": "PID-1", "fill_fraction": [0.5]},
    }
    way = (*where.split("."), name)
    lines, line = refusal(changed(SMOKE, way, values[where]))
    assert len(lines) == 1
    shown = name or "''"
    assert lines[0].startswith(f"mine.yaml:{line[way]}: {where}.{shown} = ")
    assert lines[0].endswith(
        "must have a name of 1 to 80 printable characters without '/', '\"' or surrounding spaces, "
        "because files and mesh groups use it"
    )


def refused_with(tmp_path, name, old, new):
    """Lines in which a shipped study with one text changed is refused."""
    text = (STUDIES / f"{name}.yaml").read_text()
    assert old in text
    path = tmp_path / "mine.yaml"
    path.write_text(text.replace(old, new, 1))
    with pytest.raises(StudyError) as caught:
        load_any_study(path)
    return str(caught.value).splitlines()


def test_an_empty_list_is_no_family(tmp_path):
    old = "    patch: [arm, corner, leg]\n    fill_fraction: 0.5"
    new = "    patch: arm\n    fill_fraction: []"
    assert any(
        "scenarios.location.fill_fraction = []: must have at least 1 value, not 0" in line
        for line in refused_with(tmp_path, "l_panel", old, new)
    )


@pytest.mark.parametrize(
    ("new", "key", "label"),
    [
        ("patch: arm\n    fill_fraction: [0.5, 0.50000001]", "fill_fraction", "arm_r0.5"),
        ("patch: arm\n    fill_fraction: 0.5\n    oaspl_db: [150.0001, 150.0002]", "oaspl_db", "bare_150dB"),
    ],
)  # fmt: skip
def test_two_scenarios_never_share_a_name(tmp_path, new, key, label):
    old = "patch: [arm, corner, leg]\n    fill_fraction: 0.5"
    lines = refused_with(tmp_path, "l_panel", old, new)
    assert any(
        f"scenarios.location.{key} = " in line
        and f"two scenarios would have the name {label}" in line
        for line in lines
    )


def test_a_date_that_does_not_exist_is_text(tmp_path):
    text = (STUDIES / "l_panel.yaml").read_text()
    path = tmp_path / "mine.yaml"
    first = next(line for line in text.splitlines() if line.startswith("title:"))
    path.write_text(text.replace(first, "title: 2026-02-30"))
    assert load_any_study(path).title == "2026-02-30"


def test_edges_are_held_in_the_plane_only_where_they_are_supported(tmp_path):
    values = changed(PANEL_ALONE, "panel.in_plane_edges", "held")
    path = tmp_path / "mine.yaml"
    path.write_text(yaml.safe_dump(values, allow_unicode=True))
    load_any_study(path)
    path.write_text(yaml.safe_dump(changed(values, "panel.supports", "free"), allow_unicode=True))
    with pytest.raises(StudyError, match="in_plane_edges = held: must be free; no edge"):
        load_any_study(path)
