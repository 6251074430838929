"""A mistake is told with file, line, key and value, whatever the user calls his things."""

import copy

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

STUDY = {
    "dampers": {"paper": {"law": "paper_corrected"}},
    "panel": {
        "outline_m": [1.5, 1.0],
        "corner_radius_m": 0.01,
        "holes": {},
        "section": {
            "kind": "sandwich",
            "materials": {
                "the first": {
                    "youngs_modulus_gpa": 60,
                    "poissons_ratio": 0.3,
                    "density_kg_m3": 1600,
                }
            },
            "faces": [{"material": "the first", "thickness_mm": 0.3}],
            "core": {"grade": "3/16-5056-0.0007", "thickness_mm": 24.4},
        },
        "supports": {"outline": "simply_supported", "points": {}},
        "masses": {},
        "mesh": {"kind": "triangles", "size_m": 0.1},
        "patches": {"the first": {"centre_m": [0.75, 0.5], "size_m": [0.3, 0.2]}},
        "points": {"the first": [0.75, 0.5]},
    },
    "sound": {"spectrum": "smc_s_016_2014_min_third.csv"},
    "scenarios": {"the first": {"patch": "the first", "fill_fraction": [0.5]}},
}
AREA = "centre_m, size_m, diameter_m, corners_m, corner_radius_m"
SHAPE = "must have either centre_m and size_m, or centre_m and diameter_m, or corners_m"
MATERIAL = "density_kg_m3, youngs_modulus_gpa, poissons_ratio, e1_gpa, e2_gpa, g12_gpa, nu12"
FAMILY = "patch, damper, fill_fraction, oaspl_db, steady_acceleration_g, title"

# where a name is, what is under it, and of each mistake: the key, what follows it in the message
CASES = [
    # a wrong value
    ("panel.patches", {"centre_m": [0.7, 0.5], "size_m": [0.3, -0.2]},
     {"size_m": "[1] = -0.2: must be from 0.0001 to 30"}),
    ("panel.points", [0.1, "x"], {"": "[1] = x: must be a number"}),
    ("panel.points", {"grid": 0}, {"grid": " = 0: must be at least 1"}),
    ("panel.holes", {"centre_m": [0.7, 0.5], "diameter_m": 0}, {"diameter_m": " = 0: must be from 0.0001 to 30"}),
    ("panel.masses", {"mass_kg": "much", "at_m": [0.1, 0.1]}, {"mass_kg": " = much: must be a number"}),
    ("panel.supports.points", {"kind": "glue", "at_m": [0.1, 0.1]},
     {"kind": " = glue: must be 'hinge', 'hold_down' or 'spring'"}),
    ("panel.section.materials", {"youngs_modulus_gpa": 7, "poissons_ratio": 0.7, "density_kg_m3": 9},
     {"poissons_ratio": " = 0.7: must be above -1 and below 0.5"}),
    ("scenarios", {"patch": "the first", "fill_fraction": [0.5, 1.4]},
     {"fill_fraction": "[1] = 1.4: must be from 0.02 to 1"}),
    # an unknown key
    ("panel.patches", {"centre_m": [0.7, 0.5], "size_m": [0.3, 0.2], "groop": "2"},
     {"groop": " = 2: unknown key; did you mean group?"}),
    ("panel.points", {"grid": 3, "Node": 4}, {"Node": " = 4: unknown key; allowed are grid"}),
    ("panel.holes", {"centre_m": [0.7, 0.5], "diamter_m": 1}, {"diamter_m": " = 1: unknown key; did you mean diameter_m?"}),
    ("panel.masses", {"mass_kg": 1, "at_m": [0.1, 0.1], "zzz": 1},
     {"zzz": " = 1: unknown key; allowed are mass_kg, at_m, grid, from_m, to_m"}),
    ("panel.supports.points", {"kind": "hinge", "at_m": [0.1, 0.1], "radius": 1},
     {"radius": " = 1: unknown key; did you mean radius_m?"}),
    ("panel.section.materials", {"youngs_modulus_gpa": 7, "nu": 0.3, "density_kg_m3": 9},
     {"nu": " = 0.3: unknown key; did you mean nu12?"}),
    ("scenarios", {"patch": "the first", "fill_fraction": [0.5], "oaspl": 3}, {"oaspl": " = 3: unknown key; did you mean oaspl_db?"}),
    # a missing key
    ("panel.patches", {"centre_m": [0.7, 0.5]}, {"": f" = {{centre_m: [0.7, 0.5]}}: {SHAPE}, or group"}),
    ("panel.points", {"gird": 3}, {"grid": ": missing", "gird": " = 3: unknown key; did you mean grid?"}),
    ("panel.holes", {"size_m": [0.1, 0.1]}, {"": f" = {{size_m: [0.1, 0.1]}}: {SHAPE}"}),
    ("panel.masses", {"at_m": [0.1, 0.1]}, {"mass_kg": ": missing"}),
    ("panel.supports.points", {"at_m": [0.1, 0.1]}, {"kind": ": missing"}),
    ("panel.section.materials", {"youngs_modulus_gpa": 7, "poissons_ratio": 0.3}, {"density_kg_m3": ": missing"}),
    ("scenarios", {"fill_fraction": [0.5]}, {"patch": ": missing"}),
    # no kind of value that is allowed
    ("panel.patches", 3, {"": f" = 3: must be a mapping with keys {AREA}, group"}),
    ("panel.points", 3, {"": " = 3: must be a list or a mapping with keys grid"}),
    ("panel.holes", [], {"": f" = []: must be a mapping with keys {AREA}"}),
    ("panel.masses", "x", {"": " = x: must be a mapping with keys mass_kg, at_m, grid, from_m, to_m"}),
    ("panel.supports.points", 3, {"": " = 3: must be a mapping with keys kind, at_m, grid, radius_m, stiffness_n_m"}),
    ("panel.section.materials", 3, {"": f" = 3: must be a mapping with keys {MATERIAL}"}),
    ("scenarios", 3, {"": f" = 3: must be a mapping with keys {FAMILY}"}),
    ("scenarios", {"patch": {}, "fill_fraction": [0.5]}, {"patch": " = {{}}: must be text or a list"}),
    # keys that do not fit together, which our own models say
    ("panel.points", [3, 0.5], {"": " = [3, 0.5]: point {name!r} = (3, 0.5) m leaves the panel"}),
    ("panel.patches", {"centre_m": [3, 0.5], "size_m": [0.1, 0.1]},
     {"": " = {{centre_m: [3, 0.5], size_m: [0.1, 0.1]}}: patch {name!r} = [2.95, 3.05] x"}),
    ("panel.masses", {"mass_kg": 1, "grid": 3}, {"grid": " = 3: only allowed with mesh: {{kind: file}}"}),
    ("panel.supports.points", {"kind": "spring", "at_m": [0.1, 0.1]}, {"stiffness_n_m": ": required for kind: spring"}),
    ("scenarios", {"patch": "nothing", "fill_fraction": [0.5]}, {"patch": " = nothing: must be one of panel.patches: the first"}),
]  # fmt: skip

# each of these was once taken for a name that pydantic gives to an alternative, or broke the key
NAMES = ["Left wing", "Node", "float", "kind", "a.b[0]", "7"]
ODD_NAMES = [
    "PID-1", "Rectangle", "Thin", "Supports", "thin", "str", "none", "constrained-str",
    "tuple[float, float]", "function-after[_refuse(), Node]", "[0]", ".", "Außen links", "日本",
    "grid", "at_m", "1.5", "0", "yes", "null", "~", "2024-01-01", "0x10", "<<", "\\",
    "{", "#", "[key]",
]  # fmt: skip
PLAIN = ["Left wing", "Node", "none", "7", "1.5", "yes", "null", "0x10"]


def check(refusal, case, name, quoted):
    where, value, mistakes = case
    way = tuple(where.split("."))
    values = copy.deepcopy(STUDY)
    section = values
    for key in way:
        section = section[key]
    section[name] = value
    told, line = refusal(values, quoted)
    assert len(told) == len(mistakes), told
    for key, message in mistakes.items():
        at = line.get((*way, name, key)) or line[(*way, name)]
        dotted = f"{where}.{name}" + (f".{key}" if key else "")
        message = message.replace("{{", "{").replace("}}", "}").replace("{name!r}", repr(name))
        assert any(one.startswith(f"mine.yaml:{at}: {dotted}{message}") for one in told), told


def names_of_case(case):
    kind = "+".join(case[2].values()).split(":")[-1].strip()
    return f"{case[0]}: {kind}"


@pytest.mark.parametrize("case", CASES, ids=names_of_case)
def test_a_mistake_under_a_name_is_told_with_line_key_and_value(refusal, case):
    for name in NAMES:
        check(refusal, case, name, quoted=True)


@pytest.mark.parametrize("name", PLAIN)
def test_a_name_without_quotes_is_text_as_it_is_written(refusal, name):
    for case in CASES[:8]:
        check(refusal, case, name, quoted=False)


@pytest.mark.slow
@settings(max_examples=200, deadline=None)
@given(
    case=st.sampled_from(CASES),
    name=st.sampled_from(ODD_NAMES)
    | st.text(
        st.characters(
            exclude_categories=("C", "Z"), include_characters=" ", exclude_characters='/"'
        ),
        min_size=1,
    ).filter(lambda text: text.lstrip()[:1] not in "=@+-"),  # what a spreadsheet may compute
)
def test_any_name_is_told(refusal, case, name):
    check(refusal, case, name, quoted=True)
