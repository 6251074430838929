"""Functions of universal files in the units of their labels and of data set 164, by hand."""

import struct

import numpy as np
import pytest

from pidpanel.columns import ColumnsError
from pidpanel.identify.force_files import read_force
from pidpanel.measurement.files import read_measured
from pidpanel.measurement.universal import RecordChoice

G = 9.80665
LINES = 20 + 19.8 * np.arange(101)
NONE = "NONE"
FRF, TRANSMISSIBILITY, PSD = 4, 5, 9


def axis(kind, label):
    return f"{kind:10}{0:5}{0:5}{0:5} {NONE:<20} {label:<20}\n"


def data_set(value, label, function=PSD, kind=12, below=(0, NONE), x=(18, "Hz"), count=101,
             first=20.0, step=19.8):  # fmt: skip
    """An ASCII data set 58 of a constant, by the format of its specification."""
    is_complex = isinstance(value, complex)
    parts = (value.real, value.imag) if is_complex else (value,)
    numbers = [f"{part:13.5E}" for _ in LINES for part in parts]
    name = f"{NONE:<10}"
    return "".join(
        [
            "    -1\n    58\n" + 5 * f"{NONE}\n",
            f"{function:5}{0:10}{0:5}{0:10} {name}{1:10}{3:4} {name}{1:10}{3:4}\n",
            f"{5 if is_complex else 2:10}{count:10}{1:10}{first:13.5E}{step:13.5E}{0:13.5E}\n",
            axis(*x), axis(kind, label), axis(*below), axis(0, NONE),
            *("".join(numbers[k : k + 6]) + "\n" for k in range(0, len(numbers), 6)),
            "    -1\n",
        ]
    )  # fmt: skip


def units(code, length, force):
    """A data set 164: numbers of the file's units in a metre and a newton."""
    numbers = "".join(f"{value:25.17E}".replace("E", "D") for value in (length, force, 1.0))
    return f"    -1\n   164\n{code:10}{'text':<20}{2:10}\n{numbers}\n{0:25.17E}\n    -1\n"


MILLIMETRES, INCHES, SI = units(5, 1e3, 1e3), units(7, 39.37008, 0.2248089), units(1, 1.0, 1.0)


def read(tmp_path, text, encoding="latin-1", choice=RecordChoice()):  # noqa: B008
    path = tmp_path / "test.uff"
    path.write_bytes(text.encode(encoding))
    return read_measured(path, choice)


def refused(tmp_path, text, message):
    with pytest.raises(ColumnsError) as error:
        read(tmp_path, text)
    (fault,) = error.value.faults
    assert message in fault and len(fault.splitlines()) == 1
    return fault


@pytest.mark.parametrize("encoding", ["utf-8", "latin-1", "cp1252"])
@pytest.mark.parametrize("label", ["g²/Hz", "(m/s²)²/Hz", "g·g/Hz", "µm²/s⁴/Hz"])
def test_a_label_is_read_in_utf8_and_in_latin1(tmp_path, encoding, label):
    if "⁴" in label and encoding != "utf-8":
        label = "µm²/s^4/Hz"
    factor = {"g": G**2, "(": 1.0, "µ": 1e-12}[label[0]]
    measured = read(tmp_path, data_set(0.01, label), encoding)
    np.testing.assert_allclose(measured.psd, 0.01 * factor / G**2, rtol=1e-9)


@pytest.mark.parametrize("label", ["g", "g/sqrt(Hz)", "g^2", "dB", "V^2/Hz", "EU", "m/s^2", "m/s"])
def test_what_is_no_psd_of_an_acceleration_is_refused_with_its_label(tmp_path, label):
    assert "g^2/Hz" in refused(tmp_path, data_set(0.01, label), f"unit {label!r}")


@pytest.mark.parametrize("label", ["", NONE, "none"])
def test_a_missing_unit_is_refused_or_that_of_data_set_164(tmp_path, label):
    refused(tmp_path, data_set(0.01, label), "the unit of the ordinate is missing")
    refused(tmp_path, MILLIMETRES + data_set(0.01, label, kind=0), "the unit of the ordinate is")
    for system, metre in ((SI, 1.0), (MILLIMETRES, 1e-3), (INCHES, 0.0254)):
        measured = read(tmp_path, system + data_set(0.01, label))
        np.testing.assert_allclose(measured.psd, 0.01 * (metre / G) ** 2, rtol=1e-5)
    # the units of a function stand before it, the last of several
    several = SI + data_set(0.01, label) + INCHES + MILLIMETRES + data_set(0.01, label) + SI
    measured = read(tmp_path, several, choice=RecordChoice(2))
    np.testing.assert_allclose(measured.psd, 0.01e-6 / G**2, rtol=1e-5)


def test_a_label_agrees_with_data_set_164(tmp_path):
    measured = read(tmp_path, MILLIMETRES + data_set(9617.0, "mm2/s4/Hz"))
    np.testing.assert_allclose(measured.psd, 9617e-6 / G**2, rtol=1e-9)
    for system in (MILLIMETRES, INCHES, SI):
        np.testing.assert_allclose(read(tmp_path, system + data_set(0.01, "g^2/Hz")).psd, 0.01)
    # files with SI units state them whatever their labels are
    measured = read(tmp_path, SI + data_set(0.01, "mm2/s4/Hz"))
    np.testing.assert_allclose(measured.psd, 0.01e-6 / G**2, rtol=1e-9)
    for label in ("(m/s^2)^2/Hz", "in^2/s^4/Hz"):
        refused(tmp_path, MILLIMETRES + data_set(0.01, label), "data set 164 states others")
    # metre and kilogram-force: a label in mm contradicts the metre
    refused(tmp_path, units(3, 1.0, 0.1019716) + data_set(0.01, "mm2/s4/Hz"), "states others")
    for wrong in (units(5, 1.0, 1.0), units(1, 1e3, 1.0), units(9, 0.0, 1.0), units(9, 1e-3, 1.0)):
        refused(tmp_path, wrong + data_set(0.01, NONE), "data set 164: ")


@pytest.mark.parametrize(
    ("code", "length", "force", "metre"),
    [(1, 1.0, 1.0, 1.0), (2, 3.280840, 0.2248089, 0.3048), (3, 1.0, 0.1019716, 1.0),
     (4, 3.280840, 7.233014, 0.3048), (5, 1e3, 1e3, 1e-3), (6, 1e2, 1e2, 1e-2),
     (7, 39.37008, 0.2248089, 0.0254), (8, 1e3, 0.1019716, 1e-3), (9, 10.0, 1.0, 0.1)],
)  # fmt: skip
def test_all_units_of_data_set_164(tmp_path, code, length, force, metre):
    # the factors of its specification (SDRC)
    measured = read(tmp_path, units(code, length, force) + data_set(0.01, NONE))
    np.testing.assert_allclose(measured.psd, 0.01 * (metre / G) ** 2, rtol=1e-5)
    if code != 9:
        wrong = units(code, 1.01 * length, force)
        refused(tmp_path, wrong + data_set(0.01, NONE), "contradict units code")
    for label in ("(km/s^2)^2/Hz",) if length != 1 else ():
        refused(tmp_path, units(code, length, force) + data_set(1, label), "states others")


@pytest.mark.parametrize("shift", [0, 1])
def test_a_label_may_begin_early_and_be_longer_than_the_format_has(tmp_path, shift):
    lines = data_set(0.01, "x" * 20).splitlines(keepends=True)
    lines[10] = lines[10].replace(" " * shift + "x" * 20, "( meters / second ^ 2 ) ^ 2 / Hz")
    np.testing.assert_allclose(read(tmp_path, "".join(lines)).psd, 0.01 / G**2, rtol=1e-9)


@pytest.mark.parametrize(
    ("function", "name"),
    [(1, "a time history"), (3, "a cross spectrum"),
     (6, "a coherence"), (24, "a shock response spectrum"),
     (7, "another function")],
)  # fmt: skip
def test_other_functions_are_named(tmp_path, function, name):
    refused(tmp_path, data_set(0.01, "g^2/Hz", function), f"{function} is {name}")


@pytest.mark.parametrize("function", [2, 12])
def test_spectra_with_the_unit_of_a_psd_are_one(tmp_path, function):
    psd = read(tmp_path, data_set(0.01, "(m/s^2)^2/Hz", function)).psd
    np.testing.assert_allclose(psd, 0.01 / G**2, rtol=1e-6)
    message = f"function type {function} must have the"
    refused(tmp_path, SI + data_set(0.01, NONE, function), message)
    refused(tmp_path, data_set(0.01, "g", function), "a PSD must be in")


def test_records_are_chosen_by_node_and_direction(tmp_path):
    text = "".join(
        data_set(value, "g^2/Hz").replace(f"{1:10}{3:4} ", f"{node:10}{axis:4} ", 1)
        for value, node, axis in ((1.0, 7, 1), (2.0, 7, -3), (3.0, 8, 3))
    )
    for choice, value in (
        (RecordChoice(node=8), 3.0),
        (RecordChoice(node=7, direction="z"), 2.0),
        (RecordChoice(direction="+z"), 3.0),
        (RecordChoice(direction="-z"), 2.0),
        (RecordChoice(record=1), 1.0),
    ):
        np.testing.assert_allclose(read(tmp_path, text, choice=choice).psd, value, rtol=1e-5)
    fault = refused(tmp_path, text, "has 3 data sets 58, 3 of them as selected; record, or node")
    assert fault.endswith("1 at node 7 x, 2 at node 7 -z, 3 at node 8 z")


@pytest.mark.parametrize(
    ("value", "above", "below", "ratio"),
    [
        (0.5, "g", (12, "g"), 0.5),
        (0.5, "g", (12, "m/s^2"), 0.5 * G),
        (500.0, "mm/s^2", (12, "m/s^2"), 0.5),
        (0.5, "m/s²", (12, "in/s^2"), 0.5 / 0.0254),
        (0.5, "g/g", (0, NONE), 0.5),
        (0.5, "g/g", (12, NONE), 0.5),
        (50.0, "%", (0, NONE), 0.5),
        (0.5, NONE, (12, NONE), 0.5),  # of one system, whichever it is
        (0.5, "G RMS", (12, "[g rms]"), 0.5),
    ],
)
@pytest.mark.parametrize("function", [FRF, TRANSMISSIBILITY])
@pytest.mark.parametrize("system", ["", MILLIMETRES])
def test_both_units_of_a_transmissibility_count(
    tmp_path, value, above, below, ratio, function, system
):
    if system and "m/s" in above + below[1]:
        system = SI
    text = system + data_set(complex(0.6 * value, 0.8 * value), above, function, below=below)
    measured = read(tmp_path, text)
    assert measured.over_base
    np.testing.assert_allclose(np.sqrt(measured.psd), ratio, rtol=1e-5)


@pytest.mark.parametrize(
    ("above", "below", "message"),
    [
        ("dB", (0, NONE), "unit 'dB'"),
        ("g", (0, "N"), "unit 'g' over 'N'"),
        ("g", (12, "N"), "unit 'g' over 'N'"),
        ("g", (8, "N"), "must be over a force or the acceleration of the base"),
        ("g", (12, NONE), "unit 'g': a transmissibility must be"),
        (NONE, (12, "g"), "the unit of the ordinate is missing"),
        (NONE, (0, NONE), "the unit of the ordinate is missing"),
        ("mm", (12, "m/s^2"), "unit 'mm' over 'm/s^2'"),
        ("g rms", (12, "g"), "rms on both sides"),
    ],
)
def test_other_transmissibilities_are_refused(tmp_path, above, below, message):
    refused(tmp_path, data_set(0.5 + 0j, above, FRF, below=below), message)


@pytest.mark.parametrize(
    ("x", "factor"),
    [((18, "Hz"), 1.0), ((18, NONE), 1.0), ((0, "kHz"), 1e3), ((18, "KHZ"), 1e3), ((18, "1/s"), 1),
     ((18, "rad/s"), 0.15915494309), ((1, "rpm"), 1 / 60), ((18, "cpm"), 1 / 60)],
)  # fmt: skip
def test_the_abscissa_is_in_the_unit_of_its_label(tmp_path, x, factor):
    measured = read(tmp_path, data_set(0.01, "g^2/Hz", x=x))
    np.testing.assert_allclose(measured.frequency, factor * LINES, rtol=1e-9)


@pytest.mark.parametrize("x", [(17, "s"), (17, "Hz"), (19, "rpm"), (20, NONE), (18, "s"), (0, "m")])
def test_another_abscissa_is_refused(tmp_path, x):
    refused(tmp_path, data_set(0.01, "g^2/Hz", x=x), "the abscissa must be a frequency")


def test_a_file_that_was_cut_or_padded_has_the_values_that_it_states(tmp_path):
    text = data_set(0.01, "g^2/Hz", count=5)
    refused(tmp_path, text, "has 101 values; it states 5")
    values, zeros = "  1.00000E-02", "  0.00000E+00"
    padded = text.replace(values, zeros).replace(zeros, values, 5)
    assert read(tmp_path, padded).psd.size == 5
    assert read(tmp_path, data_set(0.01, "g^2/Hz", count=99)).psd.size == 99
    refused(tmp_path, data_set(0.01, "g^2/Hz", count=102), "has 101 of the 102 values")
    refused(tmp_path, data_set(0.01 + 0.01j, "g^2/Hz"), "must be real")


@pytest.mark.parametrize("end", ["", "\n", "\r\n"])
@pytest.mark.parametrize("order", ["<", ">"])
def test_a_binary_file_has_its_labels_too(tmp_path, end, order):
    lines = data_set(0.01, "mm2/s4/Hz").splitlines(keepends=True)
    head = f"    58b{1 if order == '<' else 2:6}{2:6}{11:12}{404:12}{0:6}{0:6}{0:12}{0:12}\n"
    path = tmp_path / "test.uff"
    text = "".join([lines[0], head, *lines[2:13]]).encode()
    values = struct.pack(f"{order}101f", *[0.01] * 101)
    path.write_bytes(text + values + f"{end}    -1\n".encode())
    np.testing.assert_allclose(read_measured(path).psd, 0.01e-6 / G**2, rtol=1e-6)


def test_force_over_acceleration_without_labels_has_the_units_of_data_set_164(tmp_path):
    path = tmp_path / "force.uff"
    for system, factor in ((MILLIMETRES, 1.0), (INCHES, 175.1268), (SI, 1.0)):
        text = data_set(2.0 - 0.1j, NONE, FRF, kind=13, below=(12, NONE), first=100.0, step=1.0)
        path.write_text(system + text)
        bands = read_force(path, None, 0.1, 0.0)
        np.testing.assert_allclose(bands.mass, 20 * factor, rtol=1e-5)
    refusals = {SI[:0]: "is missing", MILLIMETRES: "data set 164 states others"}
    for system, message in refusals.items():
        label = NONE if not system else "N"
        path.write_text(system + data_set(2.0 - 0.1j, label, FRF, kind=13, below=(12, NONE)))
        with pytest.raises(ColumnsError, match=message):
            read_force(path, None, 0.1, 0.0)


@pytest.mark.parametrize("system", [SI, MILLIMETRES])
@pytest.mark.parametrize(("above", "below"), [("g", NONE), (NONE, "g")])
def test_a_label_on_one_side_does_not_go_with_another_system(tmp_path, system, above, below):
    text = system + data_set(0.5 + 0j, above, FRF, below=(12, below))
    refused(tmp_path, text, "no unit on the other side")


def test_numbers_of_another_width_are_refused(tmp_path):
    lines = data_set(0.01, "g^2/Hz", count=5).splitlines()
    text = "\n".join([*lines[:13], *5 * ["   1.00000E-02"], "    -1", ""])
    refused(tmp_path, text, "another width")


@pytest.mark.parametrize("options", [{"first": -20.0}, {"first": 2000.0, "step": -19.8}])
def test_lines_rise_from_0_hz(tmp_path, options):
    refused(tmp_path, data_set(0.01, "g^2/Hz", **options), "must rise from 0 Hz")


def test_values_have_the_range_of_a_table(tmp_path):
    refused(tmp_path, data_set(1e30, "g^2/Hz"), "from 0 to 1e+06")
    refused(tmp_path, data_set(1e7 + 0j, "g", FRF, below=(12, "g")), "from 0 to 1e+06")
