"""What of the values of a study is allowed, and most likely meant otherwise or incomplete."""

from __future__ import annotations

from collections.abc import Iterator

from pidpanel.constants import STANDARD_GRAVITY
from pidpanel.study import Study
from pidpanel.study.severity import limit_tables

THIRD = 2 ** (1 / 3)  # a third octave: a smaller gap at the ends of the data is not reported
USUAL_ACCELERATION = 0.01, 100.0  # of tests and limits [g]
# Damping ratios of bare panels with their attachments [1], and C_e below which nothing is damped
# [N s/m³]: 0.07 % of critical damping at 30 Hz, all over a panel of 4 kg/m².
USUAL_RATIO, LEAST_DAMPING = (0.001, 0.1), 1.0


def tables_in_words(study: Study) -> Iterator[str]:
    """Yield tables of damping and limits that end within the frequencies of the response."""
    from pidpanel.check_tables import damping_tables
    from pidpanel.damping.table_files import read_columns
    from pidpanel.spectra.acceleration_table import read_base_table

    low, high = study.response.frequency_hz
    for keys, table in damping_tables(study):
        frequency = read_columns(table, impedance=keys[-1] == "impedance")["frequency_hz"]
        if frequency.min() > low * THIRD or frequency.max() < high / THIRD:
            yield (
                f"{table.name} has {frequency.min():g} to {frequency.max():g} Hz, the response "
                f"{low:g} to {high:g} Hz; damping is held constant outside"
            )
    for point, table in limit_tables(study.limits).items():
        first, last = read_base_table(table).frequency[[0, -1]].tolist()
        if first > low * THIRD or last < high / THIRD:
            yield (
                f"limits.{point}.psd has {first:g} to {last:g} Hz, the response {low:g} to "
                f"{high:g} Hz; there is no margin outside"
            )


def unusual(study: Study) -> Iterator[str]:
    """Yield values that are allowed and most likely meant otherwise."""
    from pidpanel.spectra.acceleration_table import read_base_table

    ratio, (low, high) = max(study.panel.modal_damping.ratio), USUAL_RATIO
    if ratio > high:
        yield (f"panel.damping_ratio = {ratio:g} is {100 * ratio:g} %; bare panels have {low:g} to "
               f"{high:g}, and {ratio:g} % would be {ratio / 100:g}")  # fmt: skip
    for name, damper in study.dampers.items():
        damping = getattr(damper, "equivalent_damping_n_s_m3", 0.0)
        if 0 < damping < LEAST_DAMPING:
            yield (f"dampers.{name}.equivalent_damping_n_s_m3 = {damping:g} does nothing; it is per"
                   " area, usually 10 to 100000: N s/m of a cell over its area")  # fmt: skip
    tables = {f"limits.{point}.psd": table for point, table in limit_tables(study.limits).items()}
    random, sine = (study.base.random, study.base.sine) if study.base else (None, None)
    tables |= {"base.random.spectrum": random.spectrum} if random else {}
    accelerations = {key: read_base_table(table).rms for key, table in tables.items()}
    accelerations |= {f"limits.{p}.rms_g": x.rms_g for p, x in study.limits.items() if x.rms_g}
    accelerations |= {"base.sine.acceleration_g": sine.acceleration_g} if sine else {}
    for key, acceleration in accelerations.items():
        low, high = USUAL_ACCELERATION
        if not low <= acceleration <= high:
            guess = f"; {acceleration:.3g} m/s² would be {acceleration / STANDARD_GRAVITY:.3g}"
            usual = f"tests and limits have {low:g} to {high:g}{guess * (acceleration > high)}"
            yield f"{key} has {acceleration:.2g} g; {usual}"
