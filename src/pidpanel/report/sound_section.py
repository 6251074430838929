"""The sound on the page: band levels and pressure PSD."""

from collections.abc import Hashable, Mapping
from typing import Any

import numpy as np
import pandas as pd

from pidpanel.arrays import Array
from pidpanel.panel.basis import PanelBasis
from pidpanel.report import style
from pidpanel.report.html import Chart, PageCurve, PageSection, template_section
from pidpanel.report.names import Study
from pidpanel.report.response_figures import chart_picture
from pidpanel.sound.from_study import spectrum_of, stated_spectrum
from pidpanel.sound.spectrum import on_bands
from pidpanel.sound.table import read_spectrum
from pidpanel.surroundings.from_study import surroundings_text

LEVEL, PSD = "band level, dB re 20 µPa", "pressure PSD, Pa²/Hz"


def sound_setting(study: Study, basis: PanelBasis) -> str:
    """Return what hangs where, where the level was measured, and what another choice changes."""
    modes = ~basis.is_residual
    frequency, mass = basis.natural_frequency[modes], basis.modal_mass[modes]
    texts = f"the panel is {study.setting}", surroundings_text(study, basis, frequency, mass)
    return " ".join(f"{text[0].upper()}{text[1:]}." for text in texts if text)


def sound_section(study: Study, bands: pd.DataFrame) -> PageSection:
    """Return the spectrum of the sound, of a table of bands or of rows of PSD."""
    low, high = study.response.frequency_hz
    overall = 10 * np.log10(np.sum(10 ** (bands["band_spl_db"] / 10)))
    names, levels = study.acoustics.level_names, [bands["band_spl_db"].to_numpy(float)]
    is_envelope = len(names) > 1
    if is_envelope:
        shift = spectrum_of(study.acoustics).oaspl - stated_spectrum(study.acoustics).oaspl
        tables = [read_spectrum(file).shifted(shift) for file in study.acoustics.spectra]
        levels += [on_bands(table, bands["center_hz"]) for table in tables]
    psd = bands["surface_pressure_psd_pa2_hz"].to_numpy(float)
    labels = ["envelope" if is_envelope else LEVEL, *names]
    charts = [
        _steps(bands, LEVEL, dict(zip(labels, levels, strict=False)), is_log=False),
        _steps(bands, PSD, {PSD: psd}),
    ]
    values = {
        "spectrum": chart_picture("spectrum", charts, height=3.1),
        "names": names,
        "governing": _governing(bands) if is_envelope else [],
        "overall": overall,
        "is_free": study.acoustics.is_free,
        "measured": study.acoustics.field if study.acoustics.field_name == "measured" else None,
        "rows": spectrum_of(study.acoustics).rows,
        "low": low,
        "high": high,
    }
    return template_section("sound.html", "Sound", values)


def _governing(bands: pd.DataFrame) -> list[dict[Hashable, Any]]:
    """Return the spectra of an envelope with the bands from and to which each is the highest."""
    run = (bands["spectrum"] != bands["spectrum"].shift()).cumsum()
    ends = bands.groupby(run).agg(
        name=("spectrum", "first"), low=("center_hz", "first"), high=("center_hz", "last")
    )
    return ends.to_dict("records")


def _steps(
    bands: pd.DataFrame, unit: str, values: Mapping[str, Array], *, is_log: bool = True
) -> Chart:
    """Return values of bands by name, each from edge to edge."""
    edges = np.column_stack([bands["lower_hz"], bands["upper_hz"]]).ravel()
    curves = [
        PageCurve(name, np.repeat(level, 2), style.PLACES[n], "dashed" if n else "solid")
        for n, (name, level) in enumerate(values.items())
    ]
    return Chart("", edges, unit, curves, "", is_log)
