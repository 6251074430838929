"""CSV tables of damping, with units in the names of the columns: read, or refused line by line.

A row is a point, ``frequency_hz``, with ``fill_fraction`` and one amplitude of a sine
(``acceleration_g``, ``displacement_mm`` or ``velocity_m_s``) unless the table holds for all, and
one value: ``equivalent_damping_n_s_m3``, ``loss_factor`` with ``particle_mass_per_area_kg_m2``, or
``impedance_real_n_s_m3`` with ``impedance_imag_n_s_m3``. The first line names the columns,
separated by commas; ``#`` starts a comment. A text in UTF-8, with or without its mark.
"""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array
from pidpanel.columns import (
    Allowed,
    ColumnsError,
    are_numbers,
    nearest,
    numbers,
    read_rows,
    unknown,
)
from pidpanel.constants import (
    LARGEST_GAMMA,
    MOST_LOSS_FACTOR,
    MOST_LOSS_OF_REBOUND,
    MOST_OF_MASS,
    STANDARD_GRAVITY,
)
from pidpanel.damping.interpolation import lone_rows

FILL, FREQUENCY = "fill_fraction", "frequency_hz"
AMPLITUDES = ("acceleration_g", "displacement_mm", "velocity_m_s")
DAMPING, LOSS_FACTOR = "equivalent_damping_n_s_m3", "loss_factor"
REAL, IMAGINARY = "impedance_real_n_s_m3", "impedance_imag_n_s_m3"
VALUES = (DAMPING, LOSS_FACTOR, REAL)
MASS, PARTICLE_MASS = "apparent_mass_kg_m2", "particle_mass_per_area_kg_m2"
# Columns of standard errors by those of their values.
ERRORS: Mapping[str, str] = {
    DAMPING: "equivalent_damping_error_n_s_m3",
    LOSS_FACTOR: "loss_factor_error",
    REAL: "impedance_real_error_n_s_m3",
    IMAGINARY: "impedance_imag_error_n_s_m3",
    MASS: "apparent_mass_error_kg_m2",
}


MOST_MASS = 1000.0  # of the particles of a damper per area [kg/m²]

POSITIVE, NOT_NEGATIVE, ANY = Allowed(0.0, low_itself=False), Allowed(0.0), Allowed()
COLUMNS: Mapping[str, Allowed] = {
    FILL: Allowed(0.0, low_itself=False, high=1.0, hint="in percent?"),
    FREQUENCY: POSITIVE,
    **dict.fromkeys(AMPLITUDES, POSITIVE),
    AMPLITUDES[0]: Allowed(0.0, low_itself=False, high=LARGEST_GAMMA, hint="in m/s²?"),
    DAMPING: NOT_NEGATIVE,
    LOSS_FACTOR: Allowed(
        0.0,
        high=MOST_LOSS_FACTOR,
        hint="in percent? an inelastic bed has at most 4/π; of a rebounding ball give C_e",
    ),
    REAL: NOT_NEGATIVE,
    IMAGINARY: ANY,
    MASS: Allowed(-MOST_MASS, high=MOST_MASS, hint="in g/m²?"),
    PARTICLE_MASS: Allowed(0.0, low_itself=False, high=MOST_MASS, hint="in g/m²?"),
    **dict.fromkeys(ERRORS.values(), NOT_NEGATIVE),
}
# Columns of an impedance over frequency.
IMPEDANCE = (FREQUENCY, DAMPING, MASS, REAL, IMAGINARY, PARTICLE_MASS,
             *(ERRORS[value] for value in (DAMPING, MASS, REAL, IMAGINARY)))  # fmt: skip


def read_columns(
    path: Path, *, impedance: bool = False, scattered: bool = False
) -> dict[str, Array]:
    """Read the columns (n,) of a table.

    Parameters
    ----------
    impedance
        Whether it must be an impedance over frequency: C_e and m_a, or real and imaginary part,
        whatever the fill and the amplitude.
    scattered
        Whether rows may share neither amplitude nor frequency with others.

    Raises
    ------
    ColumnsError
        With all faults of the file, up to `MOST_FAULTS`.
    """
    table = read_rows(path)
    line, header = table.line, table.header
    allowed = IMPEDANCE if impedance else tuple(COLUMNS)
    faults = [f"{path}, line {line}: {says}" for says in _faults_of_header(header, allowed)]
    if not table.rows:
        faults.append(f"{path}: no rows; line {line} names the columns")
    lines, columns, of_cells = numbers(table, COLUMNS)
    faults += [f"{path}, line {number}: {says}" for number, says in of_cells]
    if not faults:
        wrong = _faults_of_rows(columns, lines, scattered=scattered)
        faults = [f"{path}, {says}" for says in wrong]
    if faults:
        raise ColumnsError(faults)
    return columns


def _faults_of_header(header: Sequence[str], allowed: Sequence[str]) -> Iterator[str]:
    """Yield names that are unknown or given twice, and what is missing among them."""
    if are_numbers(header):
        yield f"must name the columns, found the numbers {', '.join(header)}"
        return
    columns = list(header)
    for place, name in enumerate(header):
        if name not in allowed:
            columns[place] = _nearest(name, allowed)
            yield _unknown(name, place, columns[place], allowed)
        elif name in header[:place]:
            yield f"column {name}: given twice"
    if FREQUENCY not in columns:
        yield f"column {FREQUENCY}: missing"
    yield from _faults_of_choice([name for name in AMPLITUDES if name in header], "amplitude")
    if not set(VALUES) & set(columns):
        yield f"column {' or '.join(name for name in VALUES if name in allowed)}: missing"
    yield from _faults_of_choice([name for name in VALUES if name in header], "value")
    for name, needed in (
        (LOSS_FACTOR, PARTICLE_MASS),
        (REAL, IMAGINARY),
        (IMAGINARY, REAL),
        *((error, value) for value, error in ERRORS.items()),
        *([(DAMPING, MASS)] if LOSS_FACTOR not in allowed else []),
    ):
        if name in header and name in allowed and needed not in columns:
            yield f"column {needed}: missing; needed beside {name}"
    if REAL in header and MASS in header:
        yield f"column {MASS}: not allowed beside {IMAGINARY}, which is ω times it"


def _faults_of_choice(names: Sequence[str], kind: str) -> Iterator[str]:
    if len(names) > 1:
        yield f"columns {' and '.join(names)}: only one {kind} is allowed"


def _nearest(name: str, allowed: Sequence[str]) -> str:
    """Return the column that is meant; empty if none is near, or it is that of another table."""
    return "" if name in COLUMNS else nearest(name, allowed)


def _unknown(name: str, place: int, near: str, allowed: Sequence[str]) -> str:
    """Return what to say of a column that is not allowed."""
    if name in COLUMNS:
        return f"column {name}: not allowed in an impedance, which holds for all; use a table"
    return unknown(name, place, near, allowed)


def _faults_of_rows(
    columns: Mapping[str, Array], lines: Sequence[int], *, scattered: bool
) -> Iterator[str]:
    """Yield what rows, each good on its own, are not together."""
    axes = [name for name in (FILL, FREQUENCY, *AMPLITUDES) if name in columns]
    first_lines: dict[tuple[float, ...], int] = {}
    for line, point in zip(lines, zip(*(columns[name] for name in axes), strict=True), strict=True):
        if first_lines.setdefault(point, line) != line:
            coordinates = ", ".join(f"{name} = {x:g}" for name, x in zip(axes, point, strict=True))
            yield f"line {line}: {coordinates}: duplicate of line {first_lines[point]}"
    for value in VALUES:
        error = ERRORS[value]
        if value in columns and error in columns:
            for row in map(int, np.flatnonzero((columns[value] == 0) & (columns[error] > 0))):
                yield (
                    f"line {lines[row]}: {error} = {columns[error][row]:g}: "
                    f"must be 0 where {value} is 0: errors are relative to it"
                )
    yield from _faults_of_amplitude(columns, lines)
    yield from _faults_of_mass(columns, lines)
    yield from _faults_of_loss(columns, lines)
    if len(first_lines) == len(lines) and not scattered:
        yield from _faults_of_scatter(columns, lines)


def _faults_of_amplitude(columns: Mapping[str, Array], lines: Sequence[int]) -> Iterator[str]:
    """Yield the first displacement or velocity with an acceleration that no shaker has."""
    omega = 2 * np.pi * columns[FREQUENCY]
    for name, scale in (("displacement_mm", 1e-3 * omega**2), ("velocity_m_s", omega)):
        gamma = columns.get(name, np.zeros_like(omega)) * scale / STANDARD_GRAVITY
        for row in np.flatnonzero(gamma > LARGEST_GAMMA)[:1].tolist():
            yield (
                f"line {lines[row]}: {name} = {columns[name][row]:g} at"
                f" {columns[FREQUENCY][row]:g} Hz is {gamma[row]:.3g} g; at most {LARGEST_GAMMA:g}"
                f" g (in {'µm' if name == 'displacement_mm' else 'mm/s'}?)"
            )


def _faults_of_mass(columns: Mapping[str, Array], lines: Sequence[int]) -> Iterator[str]:
    """Yield masses of particles that differ though the fill does not, and m_a far above them."""
    if PARTICLE_MASS not in columns:
        return
    mass, fill = columns[PARTICLE_MASS], fill_of(columns)
    for row, (m, r) in enumerate(zip(mass, fill, strict=True)):
        first = int(np.argmax(fill == r))
        # what rounding to four digits leaves
        if abs(m / mass[first] - 1) > 1e-3:
            yield (
                f"line {lines[row]}: {PARTICLE_MASS} = {m:g}: must be the same in all rows of "
                f"a fill; line {lines[first]} has {mass[first]:g}"
            )
    apparent = columns.get(MASS, np.zeros_like(mass))
    if IMAGINARY in columns:
        apparent = columns[IMAGINARY] / (2 * np.pi * columns[FREQUENCY])
    for row in np.flatnonzero(apparent > MOST_OF_MASS * mass)[:1].tolist():
        yield (
            f"line {lines[row]}: an apparent mass of {apparent[row]:g} kg/m²: at most"
            f" {MOST_OF_MASS:g} times {PARTICLE_MASS} = {mass[row]:g}; in g/m²?"
        )


def _faults_of_loss(columns: Mapping[str, Array], lines: Sequence[int]) -> Iterator[str]:
    """Yield the first C_e that is beyond what particles of a mass can dissipate."""
    omega = 2 * np.pi * columns[FREQUENCY]
    if PARTICLE_MASS in columns:
        mass, most = columns[PARTICLE_MASS], MOST_LOSS_OF_REBOUND
    else:
        mass, most = np.full_like(omega, MOST_MASS), MOST_LOSS_FACTOR
    for name in (DAMPING, REAL):
        loss_factor = columns.get(name, np.zeros_like(omega)) / (mass * omega)
        # below 1 Hz the frequency is wrong, which is reported where the response is known
        excess = (loss_factor > most) & (columns[FREQUENCY] >= 1.0)
        for row in np.flatnonzero(excess)[:1].tolist():
            yield (
                f"line {lines[row]}: {name} = {columns[name][row]:g}: must be at most"
                f" {most * mass[row] * omega[row]:.3g} at {columns[FREQUENCY][row]:g} Hz:"
                f" {mass[row]:g} kg/m² of particles cannot dissipate more (η = {most:g})"
            )


def _faults_of_scatter(columns: Mapping[str, Array], lines: Sequence[int]) -> Iterator[str]:
    """Yield a table in which most rows are alone, so that there is nothing between them."""
    fill, amplitude = fill_of(columns), amplitude_of(columns)[1]
    lone = lone_rows(fill, amplitude, columns[FREQUENCY])
    if 2 * len(lone) > len(lines):
        yield (
            f"line {lines[lone[0]]}: {len(lone)} of {len(lines)} rows share neither amplitude "
            "nor frequency with another of their fill: several frequencies at one amplitude are "
            "needed, or several amplitudes at one frequency (exactly the same numbers)"
        )


def fill_of(columns: Mapping[str, Array]) -> Array:
    """Return the fills (n,) of the rows; 1 where the table holds for every fill."""
    return columns.get(FILL, np.ones_like(columns[FREQUENCY]))


def amplitude_of(columns: Mapping[str, Array]) -> tuple[str | None, Array]:
    """Return the name and the values (n,) of the amplitude; None and 1 where there is none."""
    for name in AMPLITUDES:
        if name in columns:
            return name, columns[name]
    return None, np.ones_like(columns[FREQUENCY])
