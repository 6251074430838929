"""Cross-spectra of microphones from a table or a universal file, and their positions."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pyuff

from pidpanel.arrays import Array, Complexes, Index
from pidpanel.columns import Allowed, ColumnsError, UserTable, numbers, read_rows
from pidpanel.sound.field import wavenumber
from pidpanel.sound.microphones import Microphones
from pidpanel.tabular.cells import HERTZ, Label

NUMBER = Allowed(1, high=1e9)
METRES = Label.named("m", "x y z", "position coordinate m")
POSITION_COLUMNS = {
    "microphone": NUMBER,
    **{f"{axis}_m": Allowed(-100, high=100, label=METRES) for axis in "xyz"},
}
SPECTRUM_COLUMNS = {
    "frequency_hz": Allowed(0.0, label=HERTZ),
    "microphone": NUMBER,
    "other": NUMBER,
    "real_pa2_hz": Allowed(-4e10, high=4e10, label=Label("Pa^2/Hz")),
    "imaginary_pa2_hz": Allowed(-4e10, high=4e10, label=Label("Pa^2/Hz")),
}

UNIVERSAL = (".uff", ".unv", ".uf58")
CROSS_SPECTRA = (2, 3, 9)  # types of functions of data set 58: auto, cross, PSD
DENSITY = "PA2/HZ"
REAL = (2, 4)  # numbers of an ordinate
LEAST_DISTANCE = 1e-3  # of two microphones [m]
# Levels in dB lie in this range and this close together over so much frequency
LEVELS, LARGEST_RATIO, LEAST_REACH = (50.0, 200.0), 2.0, 4.0

ROUNDING = 1e-3  # negative power that rounding leaves, over the whole


class CrossSpectra(NamedTuple):
    """What microphones measured."""

    position: Array  # (M, 3) [m]
    frequency: Array  # (nf,) rising [Hz]
    spectra: Complexes  # (nf, M, M) ⟨p_i p_j*⟩ with exp(iωt) [Pa²/Hz]


@lru_cache(maxsize=1)
def read_microphones(
    path: Path, positions: Path, noise: float, speed: float, *, before_wall: bool
) -> tuple[Microphones, Array]:
    """Return microphones, and the mean PSD on the face (nl,) [Pa²/Hz] that they measured.

    Parameters
    ----------
    path, positions
        As of `read_cross_spectra`, which states the errors.
    noise, before_wall
        As of `Microphones`.
    speed
        Speed of sound [m/s].
    """
    read = read_cross_spectra(path, positions)
    if before_wall and np.any(read.position[:, 2] < 0):
        raise ColumnsError([f"{positions}: z_m: must be at least 0 in a baffle, on its front"])
    k = wavenumber(read.frequency, speed)
    microphones = Microphones(read.position, noise, before_wall, k, read.spectra)
    expected = np.diagonal(microphones.expected(k), axis1=1, axis2=2)
    own = np.diagonal(read.spectra, axis1=1, axis2=2).real
    level = np.mean(own / expected, axis=1)
    return replace(microphones, spectra=read.spectra / level[:, None, None]), level


def read_cross_spectra(path: Path, positions: Path) -> CrossSpectra:
    """Read cross-spectra of all pairs of the microphones of a table of positions.

    Raises
    ------
    ColumnsError
        With the place of what is missing, given twice, or no cross-spectra.
    """
    name, position = _positions(positions)
    is_universal = path.suffix.lower() in UNIVERSAL
    frequency, pairs, values = _universal(path) if is_universal else _table(path)
    unknown = np.setdiff1d(pairs, name)
    if unknown.size:
        raise ColumnsError([f"{path}: microphone {unknown[0]} is not in {positions.name}"])
    # digits of single precision, in which files have some pairs
    rounded = np.array([float(f"{hertz:.7g}") for hertz in frequency.tolist()])
    lines, line = np.unique(rounded, return_inverse=True)
    place = np.searchsorted(name, pairs)
    spectra = np.full((lines.size, name.size, name.size), np.nan, complex)
    spectra[line, place[:, 1], place[:, 0]] = values.conj()
    spectra[line, place[:, 0], place[:, 1]] = values
    spectra = (spectra + spectra.conj().swapaxes(1, 2)) / 2
    _check_pairs(path, name, lines, spectra, np.column_stack([line, place]), values)
    return CrossSpectra(position, lines, spectra)


def _positions(path: Path) -> tuple[Index, Array]:
    table = _numbered(path, POSITION_COLUMNS, "microphone")
    name = table["microphone"]
    order = np.argsort(name, kind="stable")
    table.note(
        np.isin(np.arange(name.size), order[1:][np.diff(name[order]) == 0]),
        "microphone = {microphone:g} is given twice",
    )
    table.refuse(fewest=1, too_few="has no microphone")
    position = np.column_stack([table[f"{axis}_m"] for axis in "xyz"])
    near = np.linalg.norm(position[:, None] - position, axis=2) < LEAST_DISTANCE
    if (same := np.argwhere(np.triu(near, 1))).size:
        message = "microphones {:g} and {:g} are at one place".format(*name[same[0]])
        raise ColumnsError([f"{path}: {message}"])
    return name[order].astype(np.int64), position[order]


def _numbered(path: Path, columns: Mapping[str, Allowed], *keys: str) -> UserTable:
    """Return a table in which the numbers of microphones are whole."""
    table = numbers(read_rows(path, columns), columns)
    table.refuse()
    for key in keys:
        is_whole = table[key] == np.round(table[key])
        table.note(~is_whole, f"{key} = {{{key}:g}}: must be a whole number")
    return table


def _table(path: Path) -> tuple[Array, Index, Complexes]:
    table = _numbered(path, SPECTRUM_COLUMNS, "microphone", "other")
    table.refuse(fewest=2, too_few="must have at least two frequencies")
    pairs = np.column_stack([table["microphone"], table["other"]]).astype(np.int64)
    values = table["real_pa2_hz"] + 1j * table["imaginary_pa2_hz"]
    moves = table["frequency_hz"] > 0
    return table["frequency_hz"][moves], pairs[moves], values[moves]


def _universal(path: Path) -> tuple[Array, Index, Complexes]:
    """Return frequencies, nodes of response and reference, and values of all data sets 58."""
    try:
        file = pyuff.UFF(str(path))
        sets = [file.read_sets(n) for n, kind in enumerate(file.get_set_types()) if kind == 58]
        rows = list(_rows(sets))
    except ColumnsError as error:
        raise ColumnsError([f"{path}: {error}"]) from None
    except Exception as error:  # whatever the library meets in a broken file
        message = f"is no universal file that can be read ({type(error).__name__})"
        raise ColumnsError([f"{path}: {message}"]) from None
    if not rows:
        raise ColumnsError([f"{path}: has no data set 58 with a cross-spectrum (type 2, 3 or 9)"])
    frequency, pairs, values = (np.concatenate(part) for part in zip(*rows, strict=True))
    return frequency, pairs, values


def _rows(sets: list[dict[str, Any]]) -> Iterator[tuple[Array, Index, Complexes]]:
    for record in sets:
        if record["func_type"] not in CROSS_SPECTRA:
            continue
        pair = int(record["rsp_node"]), int(record["ref_node"])
        if objection := _objection(record):
            place = f"data set 58 of microphones {pair[0]} and {pair[1]}"
            raise ColumnsError([f"{place}: {objection}"])
        frequency = np.asarray(record["x"], float)
        rises = frequency > 0
        count = int(rises.sum())
        values = np.asarray(record["data"], complex)[rises]
        yield frequency[rises], np.tile(np.array(pair, np.int64), (count, 1)), values


def _objection(record: dict[str, Any]) -> str:
    """Return why a data set is no one-sided density with a phase; "" where it is."""
    unit, abscissa = (
        str(record[f"{axis}_axis_units_lab"]).strip() for axis in ("ordinate", "abscissa")
    )
    if "".join(c for c in unit.upper().replace("²", "2") if c not in "()^* ") != DENSITY:
        return f"unit {unit!r}; must be Pa^2/Hz"
    if abscissa.upper() not in ("HZ", "NONE", ""):
        return f"abscissa in {abscissa!r}; must be in Hz"
    if np.min(record["x"]) < 0:
        return "has frequencies below 0; must be one-sided"
    if record["rsp_node"] != record["ref_node"] and record["ord_data_type"] in REAL:
        return "is real; a cross-spectrum must have its phase"
    return ""


def _check_pairs(
    path: Path, name: Index, lines: Array, spectra: Complexes, places: Index, values: Complexes
) -> None:
    """Refuse pairs that are missing or contradict each other, levels, and negative power."""
    changed = np.zeros(spectra.shape, bool)
    differs = np.abs(spectra[tuple(places.T)] - values) > ROUNDING * np.abs(values).max(initial=0.0)
    changed[tuple(places[differs].T)] = True
    diagonal = np.eye(name.size, dtype=bool)
    for wrong, message in (
        (np.isnan(spectra), "is missing"),
        (changed, "is given twice, with other values; the other half must be conjugate"),
        (diagonal & ~(np.abs(spectra.imag) < ROUNDING * spectra.real), "must be real and above 0"),
    ):
        if wrong.any():
            line, first, second = np.argwhere(wrong)[0]
            pair = f"microphones {name[first]} and {name[second]}"
            raise ColumnsError([f"{path}: {lines[line]:g} Hz, {pair}: {message}"])
    if lines.size < 2:
        raise ColumnsError([f"{path}: must have at least two frequencies, not {lines.size}"])
    low, high = spectra.real.min(), spectra.real.max()
    is_level = LEVELS[0] < low and high < min(LEVELS[1], LARGEST_RATIO * low)
    if is_level and lines[-1] > LEAST_REACH * lines[0]:
        message = f"all are {low:.3g} to {high:.3g}, as levels in dB are; must be Pa^2/Hz"
        raise ColumnsError([f"{path}: {message}"])
    power = np.linalg.eigvalsh(spectra)
    negative = np.flatnonzero(power[:, 0] < -ROUNDING * power.sum(axis=1))
    if negative.size:
        line = negative[0]
        message = "the matrix has negative power; must be positive semidefinite"
        raise ColumnsError([f"{path}: {lines[line]:g} Hz: {message}"])
