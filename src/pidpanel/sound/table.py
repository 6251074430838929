"""Tables of band levels and of pressure PSDs.

Band levels have the columns ``center_hz`` and ``spl_db``; a PSD has ``frequency_hz`` and
``psd_pa2_hz``. Other usual names and units are known too.
"""

from collections.abc import Sequence
from pathlib import Path

import numpy as np

from pidpanel.arrays import Array, Index
from pidpanel.columns import Allowed, ColumnsError, UserTable, numbers, read_rows
from pidpanel.sound.spectrum import BAND_WIDTH, BandKind, BandSpectrum, Spectrum, envelope
from pidpanel.spectra.acceleration_table import break_points, summary
from pidpanel.spectra.third_octaves import center_frequency
from pidpanel.tabular.cells import HERTZ, Label
from pidpanel.tabular.rows import TableRows

# Relative distance allowed between a stated centre and the exact one.
#
# Nominal centres (ISO 266) lie within 0.95 % of 10^(N/10), base-2 ones within 1.4 % above
# 16 Hz, and half the way to the next third is 12 %.
# Below 20 Hz they are also written without their decimals: 12 or 13 for 12.5.
CENTER_TOLERANCE = 0.02
LOW_TOLERANCE, LOW = 0.05, 20.0

OVERALL_TOLERANCE_DB = 0.5  # difference of a stated overall level: of rounded bands

# Band levels allowed [dB]: 191 dB is one atmosphere rms, so more is a typing error. A scaled or
# filtered spectrum may have bands far below the threshold of hearing, 0 dB.
LEVEL_RANGE = (-100.0, 200.0)

# Levels of neighbouring bands of a launcher or a chamber differ by less [dB].
LARGEST_STEP_DB = 40.0

BAND_COLUMNS = {
    "center_hz": Allowed(0.0, low_itself=False, label=HERTZ),
    "spl_db": Allowed(
        LEVEL_RANGE[0], high=LEVEL_RANGE[1], hint="in Pa?",
        label=Label.named(
            "dB", "spl l lp level levels pegel schalldruckpegel",
            "sound pressure acoustic band octave third 1 3 max maximum limit mpe",
        ),
    ),
}  # fmt: skip

PSD_COLUMNS = {
    "frequency_hz": Allowed(0.0, low_itself=False, label=HERTZ),
    # 200 dB in a band of 1 Hz
    "psd_pa2_hz": Allowed(
        0.0, low_itself=False, high=4e10,
        label=Label.named("Pa^2/Hz", "psd asd apsd density", "pressure power spectral sound"),
    ),
}  # fmt: skip

# Words of a comment line `# band: …` for the kind, which must agree with the centres.
BAND_WORDS: dict[str, BandKind] = {"1/3 octave": "third octave", "1/1 octave": "octave"}


def _bands(text: TableRows) -> tuple[BandSpectrum, Array]:
    """Return band levels and stated centres; the ratio of neighbouring centres gives the kind.

    Stated centres may be nominal (31.5, 63, 125 …) or exact; the exact base-10 centre is used.
    """
    table = numbers(text, BAND_COLUMNS)
    band_number = _band_numbers(table)
    bands = f"{len(table.lines) or 'no'} band{'s' * (not table.lines)}"
    reason = f"{bands}; at least two are needed to tell octaves from thirds"
    table.refuse(fewest=2, too_few=reason)
    kind = _band_kind(table, band_number)
    _note_comments(table, kind)
    _note_odd_levels(table)
    table.refuse()
    spectrum = BandSpectrum.of_levels(kind, band_number, table["spl_db"], text.source)
    return spectrum, table["center_hz"]


def _note_odd_levels(table: UserTable) -> None:
    """Note bands far below or above both neighbours, as with a digit missing."""
    level = table["spl_db"]
    lower, upper = np.roll(level, 1), np.roll(level, -1)
    lowest, highest = np.minimum(lower, upper), np.maximum(lower, upper)
    for side, is_odd in (
        ("below", level < lowest - LARGEST_STEP_DB),
        ("above", level > highest + LARGEST_STEP_DB),
    ):
        is_odd[[0, -1]] = False
        message = f"spl_db = {{spl_db:g}}: more than {LARGEST_STEP_DB:g} dB {side} both neighbours,"
        table.note(is_odd, message + " {lower:g} and {upper:g} dB", lower=lower, upper=upper)


def _note_comments(table: UserTable, kind: BandKind) -> None:
    """Note comments that state another kind of band than the centres have."""
    for line, comment in table.text.comments:
        for words, stated in BAND_WORDS.items():
            if comment.startswith(f"band: {words}") and stated != kind:
                message = f"the comment states {stated} bands, the centres are those of {kind} "
                table.faults.add(line, f"{message}bands")


def _band_numbers(table: UserTable) -> Index:
    """Return N (n,) of the nearest exact centre 10^(N/10); note centres that have none."""
    center = table.columns.get("center_hz", np.empty(0))
    # what is not above 0 is noted already
    number = np.round(10 * np.log10(np.where(center > 0, center, 1.0))).astype(int)
    exact = center_frequency(number)
    message = "center_hz = {center_hz:g} is not a preferred centre; the nearest is {exact:.4g} Hz"
    allowed = np.where(center < LOW, LOW_TOLERANCE, CENTER_TOLERANCE)
    is_far = (center > 0) & (np.abs(center / exact - 1) > allowed)
    message += " (within {percent:g} %)"
    table.note(is_far, message, exact=exact, percent=100 * allowed)
    return number


def _band_kind(table: UserTable, band_number: Index) -> BandKind:
    """Return the kind of band from the steps between neighbours; note what does not adjoin."""
    steps = np.diff(band_number)
    for wrong, fault in ((steps == 0, "appears twice"), (steps < 0, "follows a higher centre")):
        table.note(
            np.append(False, wrong), f"center_hz = {{center_hz:g}} {fault}; centres must increase"
        )
    if table.faults:
        return "third octave"
    kind: BandKind = "third octave" if steps.min() < BAND_WIDTH["octave"] else "octave"
    gaps = np.append(False, steps != BAND_WIDTH[kind])
    message = "between {lower:g} and {center_hz:g} Hz there is a gap; "
    lower = np.roll(table["center_hz"], 1)
    table.note(gaps, f"{message}{kind} bands must adjoin", lower=lower)
    if kind == "octave" and band_number[0] % 3:
        is_first = np.arange(band_number.size) == 0
        message = "center_hz = {center_hz:g} is not an octave centre "
        table.note(is_first, message + "(31.5, 63, 125, 250, 500, 1000 … Hz)")
    return kind


def read_spectrum(path: str | Path) -> Spectrum:
    """Read a table of band levels or of a pressure PSD, with its comments as the source.

    Raises
    ------
    ColumnsError
        If the file has faults; all are listed.
    """
    return read_pressure(path)[0]


def read_envelope(paths: Sequence[Path]) -> tuple[Spectrum, list[str]]:
    """Read some tables: the highest in each third octave, and the name of the file that has it.

    A single table is returned as it is.
    """
    spectra = [read_spectrum(path) for path in paths]
    if len(spectra) == 1:
        return spectra[0], [paths[0].name]
    highest, governing = envelope(spectra)
    return highest, [paths[place].name for place in governing.tolist()]


def read_pressure(path: str | Path) -> tuple[Spectrum, str]:
    """Read a spectrum, and say in a line what was understood; see `read_spectrum`.

    Returns
    -------
    The spectrum, and its bands or rows, range, overall level, file and what was read otherwise
    than as written.
    """
    text = read_rows(Path(path), {**BAND_COLUMNS, **PSD_COLUMNS}, has_overall=True)
    is_psd = any(name.lower().startswith("psd") for name in text.header)
    columns = PSD_COLUMNS if is_psd else BAND_COLUMNS
    first = {name: next(iter(columns)) for name in ("center_hz", "frequency_hz")}
    text = text._replace(header=[first.get(name, name) for name in text.header])
    if is_psd:
        spectrum = Spectrum(break_points(text, PSD_COLUMNS), text.source)
        frequency = spectrum.points.frequency
        count = f"{frequency.size} rows"
    else:
        spectrum, frequency = _bands(text)
        count = f"{frequency.size} {spectrum.kind}s"
    for line, value in text.overall:
        if abs(value - spectrum.oaspl) > OVERALL_TOLERANCE_DB:
            message = f"states {value:g} dB, its {spectrum.rows} sum to {spectrum.oaspl:.1f} dB; "
            message += f"must agree within {OVERALL_TOLERANCE_DB:g} dB"
            raise ColumnsError([f"{path}, line {line}: {message}"])
    return spectrum, summary(text, count, frequency, f"{spectrum.oaspl:.1f} dB")
