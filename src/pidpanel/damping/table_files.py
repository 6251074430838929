"""CSV tables of damping, with units in the names of the columns: read, or refused line by line.

A row is a point, ``frequency_hz``, with ``fill_fraction`` and one amplitude of a sine
(``acceleration_g``, ``displacement_mm`` or ``velocity_m_s``) unless the table holds for all, and
one value: ``equivalent_damping_n_s_m3``, ``loss_factor`` with ``particle_mass_per_area_kg_m2``, or
``impedance_real_n_s_m3`` with ``impedance_imag_n_s_m3``. The first line names the columns,
separated by commas; ``#`` starts a comment. A text in UTF-8, with or without its mark.
"""

from collections.abc import Hashable, Iterable, Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.columns import (
    Allowed,
    UserTable,
    are_numbers,
    faults_of_names,
    nearest,
    numbers,
    read_rows,
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
        If the file has faults; up to `MOST_FAULTS` are listed.
    """
    text = read_rows(path)
    allowed = IMPEDANCE if impedance else tuple(COLUMNS)
    table = numbers(text, COLUMNS, list(_faults_of_header(text.header, allowed)))
    table.refuse(fewest=1, too_few=f"no rows; line {text.line} names the columns")
    _note_repeats(table)
    if not table.faults and not scattered:
        _note_scatter(table)
    _note_errors(table)
    _note_amplitudes(table)
    _note_masses(table)
    _note_losses(table)
    table.refuse()
    return table.columns


def _faults_of_header(header: Sequence[str], allowed: Sequence[str]) -> Iterator[str]:
    """Yield names that are unknown or given twice, and what is missing among them."""
    elsewhere = {
        name: f"column {name}: not allowed in an impedance, which holds for all; use a table"
        for name in COLUMNS
        if name not in allowed
    }
    yield from faults_of_names(header, allowed, elsewhere)
    if are_numbers(header):
        return
    # a misspelt column is not missing
    meant = {nearest(name, allowed) for name in header if name not in elsewhere}
    choices = {"amplitude": AMPLITUDES, "value": VALUES}
    if FREQUENCY not in meant:
        yield f"column {FREQUENCY}: missing"
    if not set(VALUES) & meant:
        yield f"column {' or '.join(name for name in VALUES if name in allowed)}: missing"
    for kind, names in choices.items():
        given = [name for name in names if name in header]
        if len(given) > 1:
            yield f"columns {' and '.join(given)}: only one {kind} is allowed"
    for name, needed in (
        (LOSS_FACTOR, PARTICLE_MASS),
        (REAL, IMAGINARY),
        (IMAGINARY, REAL),
        *((error, value) for value, error in ERRORS.items()),
        *([(DAMPING, MASS)] if LOSS_FACTOR not in allowed else []),
    ):
        if name in header and name in allowed and needed not in meant:
            yield f"column {needed}: missing; needed with {name}"
    if REAL in header and MASS in header:
        yield f"column {MASS}: not allowed with {IMAGINARY}, which is ω times it"


def _note_repeats(table: UserTable) -> None:
    """Note rows at the point of a row before."""
    axes = [name for name in (FILL, FREQUENCY, *AMPLITUDES) if name in table.columns]
    first = _first_rows(zip(*(table[name].tolist() for name in axes), strict=True))
    message = ", ".join(f"{name} = {{{name}:g}}" for name in axes) + ": duplicate of line {line}"
    table.note(first < np.arange(first.size), message, line=np.array(table.lines)[first])


def _first_rows(keys: Iterable[Hashable]) -> Index:
    """Return the first row with the key of each."""
    rows: dict[Hashable, int] = {}
    return np.array([rows.setdefault(key, row) for row, key in enumerate(keys)])


def _note_errors(table: UserTable) -> None:
    """Note errors of values that are 0, and the first row where all values are below theirs."""
    for value in VALUES:
        error = ERRORS[value]
        if value in table.columns and error in table.columns:
            message = (
                f"{error} = {{{error}:g}}: must be 0 where {value} is 0: errors are relative to it"
            )
            table.note((table[value] == 0) & (table[error] > 0), message)
            if np.all((table[error] > table[value]) & (table[value] > 0)):
                message = (
                    f"{value} = {{{value}:g}}: below its error, as in every row; exchanged columns?"
                )
                table.note(np.arange(len(table.lines)) == 0, message)


def _note_amplitudes(table: UserTable) -> None:
    """Note the first displacement or velocity with an acceleration that no shaker has."""
    omega = 2 * np.pi * table[FREQUENCY]
    for name, unit in (("displacement_mm", "µm"), ("velocity_m_s", "mm/s")):
        if name in table.columns:
            gamma = table[name] * gamma_per_unit(name, omega)
            message = f"{name} = {{{name}:g}} at {{frequency_hz:g}} Hz is {{gamma:.3g}} g; at most"
            message += f" {LARGEST_GAMMA:g} g (in {unit}?)"
            table.note(gamma > LARGEST_GAMMA, message, first=True, gamma=gamma)


def _note_masses(table: UserTable) -> None:
    """Note masses of particles that differ though the fill does not, and m_a far above them."""
    if PARTICLE_MASS not in table.columns:
        return
    mass, fill = table[PARTICLE_MASS], fill_of(table.columns)
    first = _first_rows(fill.tolist())
    message = f"{PARTICLE_MASS} = {{mass:g}}: must be the same in all rows of a fill; "
    # what rounding to four digits leaves
    line, same = np.array(table.lines)[first], mass[first]
    message += "line {line} has {same:g}"
    table.note(np.abs(mass / same - 1) > 1e-3, message, mass=mass, same=same, line=line)
    apparent = table.columns.get(MASS, np.zeros_like(mass))
    if IMAGINARY in table.columns:
        apparent = table[IMAGINARY] / (2 * np.pi * table[FREQUENCY])
    message = f"an apparent mass of {{apparent:g}} kg/m²: at most {MOST_OF_MASS:g} times "
    message += f"{PARTICLE_MASS} = {{mass:g}}; in g/m²?"
    table.note(apparent > MOST_OF_MASS * mass, message, first=True, apparent=apparent, mass=mass)


def _note_losses(table: UserTable) -> None:
    """Note the first C_e that is beyond what particles of a mass can dissipate."""
    omega = 2 * np.pi * table[FREQUENCY]
    mass, eta = np.full_like(omega, MOST_MASS), MOST_LOSS_FACTOR
    if PARTICLE_MASS in table.columns:
        mass, eta = table[PARTICLE_MASS], MOST_LOSS_OF_REBOUND
    largest = eta * mass * omega
    for name in (DAMPING, REAL):
        if name not in table.columns:
            continue
        # below 1 Hz the frequency is wrong, which is reported where the response is known
        excess = (table[name] > largest) & (table[FREQUENCY] >= 1.0)
        message = f"{name} = {{{name}:g}}: must be at most {{largest:.3g}} at {{frequency_hz:g}} "
        message += f"Hz: {{mass:g}} kg/m² of particles cannot dissipate more (η = {eta:g})"
        table.note(excess, message, first=True, largest=largest, mass=mass)


def _note_scatter(table: UserTable) -> None:
    """Note a table in which most rows are alone, so that there is nothing between them."""
    amplitude = amplitude_of(table.columns)[1]
    lone = lone_rows(fill_of(table.columns), amplitude, table[FREQUENCY])
    count = len(table.lines)
    if 2 * len(lone) > count:
        table.faults.add(
            table.lines[lone[0]],
            f"{len(lone)} of {count} rows share neither amplitude "
            "nor frequency with another of their fill: several frequencies at one amplitude are "
            "needed, or several amplitudes at one frequency (exactly the same numbers)",
        )


def gamma_per_unit(amplitude: str, omega: Array) -> Array:
    """Return Γ (n,) of a sine with an amplitude of 1, by the name of its column."""
    scales = {
        "acceleration_g": np.ones_like(omega),
        "displacement_mm": 1e-3 * omega**2 / STANDARD_GRAVITY,
        "velocity_m_s": omega / STANDARD_GRAVITY,
    }
    return scales[amplitude]


def quantities_of(columns: Mapping[str, Array]) -> tuple[str, str, str, str]:
    """Return the names of C_e or its substitute, and of m_a or its own, each with its error."""
    value = next(name for name in VALUES if name in columns)
    mass = IMAGINARY if value == REAL else MASS
    return value, ERRORS[value], mass, ERRORS[mass]


def fill_of(columns: Mapping[str, Array]) -> Array:
    """Return the fills (n,) of the rows; 1 where the table holds for every fill."""
    return columns.get(FILL, np.ones_like(columns[FREQUENCY]))


def amplitude_of(columns: Mapping[str, Array]) -> tuple[str | None, Array]:
    """Return the name and the values (n,) of the amplitude; None and 1 where there is none."""
    for name in AMPLITUDES:
        if name in columns:
            return name, columns[name]
    return None, np.ones_like(columns[FREQUENCY])
