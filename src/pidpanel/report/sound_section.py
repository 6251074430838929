"""The sound on the page: band levels and pressure PSD."""

import numpy as np
import pandas as pd

from pidpanel.panel.basis import PanelBasis
from pidpanel.report import style
from pidpanel.report.html import Chart, PageCurve, PageSection, template_section
from pidpanel.report.names import Study
from pidpanel.report.response_figures import chart_picture
from pidpanel.sound.from_study import spectrum_of
from pidpanel.surroundings.from_study import surroundings_text

LEVEL = "band level, dB re 20 µPa"


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
    charts = [
        _steps(bands, "band_spl_db", LEVEL, is_log=False),
        _steps(bands, "surface_pressure_psd_pa2_hz", "pressure PSD, Pa²/Hz"),
    ]
    values = {
        "spectrum": chart_picture("spectrum", charts, height=3.1),
        "name": study.acoustics.level_file.name,
        "overall": overall,
        "is_free": study.acoustics.is_free,
        "rows": spectrum_of(study.acoustics).rows,
        "low": low,
        "high": high,
    }
    return template_section("sound.html", "Sound", values)


def _steps(bands: pd.DataFrame, column: str, unit: str, *, is_log: bool = True) -> Chart:
    """Return values of bands, each from edge to edge."""
    edges = np.column_stack([bands["lower_hz"], bands["upper_hz"]]).ravel()
    values = np.repeat(bands[column].to_numpy(float), 2)
    return Chart("", edges, unit, [PageCurve(unit, values, style.PLACES[0])], "", is_log)
