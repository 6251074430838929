"""CSV tables of damping: every fault one line with its place, and none accepted."""

import math
import re

import numpy as np
import pytest
import yaml
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter

from pidpanel.columns import MOST_FAULTS, ColumnsError
from pidpanel.damping.from_study import read_table
from pidpanel.damping.table_files import COLUMNS, read_columns
from pidpanel.paths import PROJECT
from pidpanel.study.dampers import STATED, AnyDamper

C, F = "equivalent_damping_n_s_m3", "frequency_hz"
ETA, M = "loss_factor", "particle_mass_per_area_kg_m2"


def faults(tmp_path, text, *, impedance=False):
    """Faults of a text or of bytes, the name of the file left out."""
    path = tmp_path / "lab.csv"
    path.write_bytes(text if isinstance(text, bytes) else text.encode())
    with pytest.raises(ColumnsError) as caught:
        read_columns(path, impedance=impedance)
    assert str(caught.value).split("\n") == list(caught.value.faults)
    assert all(fault.startswith(str(path)) for fault in caught.value.faults)
    return [fault.removeprefix(str(path)).lstrip(":, ") for fault in caught.value.faults]


# (text, beginnings of its faults)
FAULTS = {
    "empty": ("", ["empty; the first line must name the columns"]),
    "header alone": (f"{F},{C}\n", ["no rows; line 1 names the columns"]),
    "no header": ("100,5\n200,6\n", ["line 1: must name the columns, found the numbers 100, 5"]),
    "µm for mm": (
        f"{F},displacement_mm,{C}\n10,900,500\n300,900,500\n400,900,500\n",
        ["line 3: displacement_mm = 900 at 300 Hz is 3.26e+05 g; at most 2000 g (in µm?)"],
    ),
    "mm/s for m/s": (
        f"{F},velocity_m_s,{C}\n300,90,500\n",
        ["line 2: velocity_m_s = 90 at 300 Hz is 1.73e+04 g; at most 2000 g (in mm/s?)"],
    ),
    "m/s² for g": (f"{F},acceleration_g,{C}\n30,2e4,500\n", ["line 2: acceleration_g = 2e4: must"]),
    # 2·1000 kg/m²·2π·100 Hz, and η = 250 of the particles' own 5 kg/m²
    "more loss than any bed": (
        f"{F},{C}\n100,5e7\n",
        [f"line 2: {C} = 5e+07: must be at most 1.26e+06 at 100 Hz: 1000 kg/m² of particles"],
    ),
    "more loss than a rebounding ball": (
        f"{F},{C},particle_mass_per_area_kg_m2\n100,1e6,5\n",
        [f"line 2: {C} = 1e+06: must be at most 7.85e+05 at 100 Hz: 5 kg/m² of particles"],
    ),
    "a short row": (f"{F},{C}\n100\n", ["line 2: has 1 values, must have 2"]),
    "nan": (f"{F},{C}\n100,nan\n", [f"line 2: {C} = 'nan': must be a finite number"]),
    "an empty cell": (f"{F},{C}\n100,\n", [f"line 2: {C} = (empty): must be a number"]),
    "negative": (f"{F},{C}\n100,-5\n", [f"line 2: {C} = -5: must be at least 0"]),
    "zero amplitude": (
        f"{F},velocity_m_s,{C}\n10,0,5\n",
        ["line 2: velocity_m_s = 0: must be above 0"],
    ),
    "fill in percent": (
        f"fill_fraction,{F},{C}\n50,100,5\n",
        ["line 2: fill_fraction = 50: must be above 0 and at most 1 (in percent?)"],
    ),
    "loss factor in percent": (
        f"{F},{ETA},{M}\n100,0.2,3\n200,15,3\n300,2.1,3\n",
        ["line 3: loss_factor = 15: must be from 0 to 2 (in percent?",
         "line 4: loss_factor = 2.1: must be"],
    ),
    "negative error": (
        f"{F},{C},equivalent_damping_error_n_s_m3\n100,5,-1\n",
        ["line 2: equivalent_damping_error_n_s_m3 = -1: must be at least 0"],
    ),
    "exchanged columns": (
        f"{F},{C},equivalent_damping_error_n_s_m3\n100,5,300\n200,6,310\n",
        [f"line 2: {C} = 5: below its error, as in every row; exchanged columns?"],
    ),
    "an error of zero damping": (
        f"{F},{C},equivalent_damping_error_n_s_m3\n100,0,1\n200,0,0\n",
        [f"line 2: equivalent_damping_error_n_s_m3 = 1: must be 0 where {C} is 0"],
    ),
    "misspelt": (
        f"fill_fraction,frequncy_hz,{C}\n0.5,100,5\n",
        ["line 1: column 'frequncy_hz': unknown; did you mean frequency_hz?"],
    ),
    "unknown": (
        f"{F},{C},operator\n100,5,7\n",
        ["line 1: column 'operator': unknown; allowed are fill_fraction, frequency_hz,"],
    ),
    "a column twice": (f"{F},{F},{C}\n1,2,3\n", [f"line 1: column {F}: given twice"]),
    "no frequency": (f"{C}\n5\n", ["line 1: column frequency_hz: missing"]),
    "no value": (
        f"{F}\n100\n",
        [f"line 1: column {C} or loss_factor or impedance_real_n_s_m3: missing"],
    ),
    "loss factor without mass": (
        f"{F},{ETA}\n100,0.1\n",
        [f"line 1: column {M}: missing; needed with loss_factor"],
    ),
    "half an impedance": (
        f"{F},impedance_real_n_s_m3\n100,5\n",
        ["line 1: column impedance_imag_n_s_m3: missing; needed with impedance_real_n_s_m3"],
    ),
    "mass twice": (
        f"{F},impedance_real_n_s_m3,impedance_imag_n_s_m3,apparent_mass_kg_m2\n100,5,1,1\n",
        ["line 1: column apparent_mass_kg_m2: not allowed with impedance_imag_n_s_m3"],
    ),
    "an error alone": (
        f"{F},{C},apparent_mass_error_kg_m2\n100,5,1\n",
        ["line 1: column apparent_mass_kg_m2: missing; needed with apparent_mass_error_kg_m2"],
    ),
    "two amplitudes": (
        f"{F},acceleration_g,displacement_mm,{C}\n100,5,1,1\n",
        ["line 1: columns acceleration_g and displacement_mm: only one amplitude is allowed"],
    ),
    "two values": (
        f"{F},{C},{ETA},{M}\n100,5,0.1,1\n",
        [f"line 1: columns {C} and loss_factor: only one value is allowed"],
    ),
    "duplicate rows": (
        f"{F},{C}\n100,5\n# again\n100.0,6\n1e2,5\n",
        ["line 4: frequency_hz = 100: duplicate of line 2",
         "line 5: frequency_hz = 100: duplicate of line 2"],
    ),
    "two masses of a fill": (
        f"fill_fraction,{F},{C},{M}\n0.5,100,5,3\n0.5,200,5,3.01\n0.7,100,5,4\n0.7,200,5,4\n",
        [f"line 3: {M} = 3.01: must be the same in all rows of a fill; line 2 has 3"],
    ),
    "rows that share nothing": (
        f"{F},acceleration_g,{C}\n100,5,1\n110,5.1,1\n120,5.2,1\n",
        ["line 2: 3 of 3 rows share neither amplitude nor frequency"],
    ),
    "several": (
        f"{F},{C},fill\nnan,-1,5\n\n-3,2,1\n",
        ["line 1: column 'fill': unknown; did you mean fill_fraction?",
         f"line 2: {F} = 'nan': must be", f"line 2: {C} = -1: must be", f"line 4: {F} = -3: must"],
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", FAULTS)
def test_every_fault_is_told_in_one_line_with_its_place(tmp_path, name):
    text, begins = FAULTS[name]
    told = faults(tmp_path, text)
    assert len(told) == len(begins)
    for fault, begin in zip(told, begins, strict=True):
        assert fault.startswith(begin)


@pytest.mark.parametrize(
    ("text", "begin"),
    [
        (f"{F},{C}\n100,5\n", f"line 1: column apparent_mass_kg_m2: missing; needed with {C}"),
        (f"{F},fill_fraction,{C},apparent_mass_kg_m2\n100,1,5,1\n",
         "line 1: column fill_fraction: not allowed in an impedance"),
        (f"{F}\n100\n", f"line 1: column {C} or impedance_real_n_s_m3: missing"),
    ],
)  # fmt: skip
def test_an_impedance_is_complex_and_over_frequency_alone(tmp_path, text, begin):
    (fault,) = faults(tmp_path, text, impedance=True)
    assert fault.startswith(begin)


def test_of_many_faults_the_first_are_told_and_the_others_counted(tmp_path):
    told = faults(tmp_path, ",".join([F, C, *(f"{i}x{i}" for i in range(50))]) + "\n")
    assert len(told) == MOST_FAULTS + 1
    assert told[-1] == f"{51 - MOST_FAULTS} further mistakes"


@pytest.mark.parametrize(
    "text",
    [
        f"{F},{C}\n100,5\n400,0\n",
        f"\ufeff{F},{C}\r\n100,5\r\n400,0\r\n",
        f'"{F}", "{C}"\n100, 5e0\n+400.,.0\n',
        f"# measured in May; at 20 °C\n\n{F},{C} # per area\n100,5\n\n400,0 # none\n",
    ],
    ids=["plain", "by Excel", "quoted", "with comments"],
)
def test_what_is_a_table_is_read_as_it_stands(tmp_path, text):
    (tmp_path / "lab.csv").write_bytes(text.encode())
    columns = read_columns(tmp_path / "lab.csv")
    assert {name: values.tolist() for name, values in columns.items()} == {
        F: [100.0, 400.0], C: [5.0, 0.0]
    }  # fmt: skip


@pytest.mark.slow
@settings(suppress_health_check=[HealthCheck.function_scoped_fixture])
@given(st.sampled_from([C, F, "fill_fraction", "acceleration_g"]), st.text(max_size=12))
def test_no_cell_is_read_as_anything_but_the_number_that_is_written(tmp_path, column, cell):
    # whatever is in a cell: the number that it is in Python's words, within what is allowed, or
    # one line or more.
    header = ["fill_fraction", F, "acceleration_g", C]
    cells = dict.fromkeys(header, "0.5") | {column: cell}
    path = tmp_path / "any.csv"
    text = ",".join(header) + "\n" + ",".join(cells.values())
    path.write_text(text, encoding="utf-8", errors="replace", newline="")
    try:
        value = read_columns(path)[column]
    except ColumnsError as error:
        assert all("\n" not in fault and fault.isprintable() for fault in error.faults)
        return
    plain = cell.partition("#")[0].strip().strip('"').strip()
    assert value == [float(plain)] and plain.isascii() and "_" not in plain
    assert math.isfinite(value[0]) and not COLUMNS[column].refuses(value[0])


def test_the_examples_of_the_page_are_a_table_and_dampers(tmp_path):
    page = (PROJECT / "docs" / "tables.md").read_text()
    yaml_block, table = re.findall("```(?:yaml)?\n(.*?)```", page, flags=re.DOTALL)[:2]
    dampers = yaml.safe_load(yaml_block)["dampers"].values()
    kinds = [TypeAdapter(AnyDamper).validate_python(one).kind for one in dampers]
    assert set(kinds) == {*STATED, "particles"}
    (tmp_path / "lab.csv").write_text(table)
    assert len(read_columns(tmp_path / "lab.csv")[F]) == 4
    for column in COLUMNS:
        assert f"`{column}`" in page


def test_an_apparent_mass_far_above_that_of_the_particles_is_refused(tmp_path):
    path = tmp_path / "steel.csv"
    head = f"{F},{C},apparent_mass_kg_m2,particle_mass_per_area_kg_m2\n"
    path.write_text(head + "100,500,357,1\n")
    with pytest.raises(ColumnsError, match=r"apparent mass of 357 kg/m²: at most 10 times"):
        read_columns(path)
    path.write_text(head + "100,500,80,10\n")  # of particles in resonance with their gap
    assert read_columns(path)["apparent_mass_kg_m2"] == [80]


def test_the_particles_of_a_table_can_act_with_their_own_mass(tmp_path):
    path = tmp_path / "steel.csv"
    path.write_text(f"{F},{C},particle_mass_per_area_kg_m2\n100,500,10\n200,500,10\n")
    frequency = np.array([120.0])
    masses = [
        read_table(path, apparent_mass=way)(frequency, 0.5, 1.0).apparent_mass.item()
        for way in (None, "particles")
    ]
    assert masses == [0.0, pytest.approx(10.0)]
    path.write_text(f"{F},{C}\n100,500\n200,500\n")
    with pytest.raises(ColumnsError, match="particle_mass_per_area_kg_m2: missing"):
        read_table(path, apparent_mass="particles")
